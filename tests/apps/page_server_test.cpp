// SPDX-License-Identifier: BSD-3-Clause
// The server of the live page against browsers that are honest, slow, gone, or of another site; and
// `magimu stream --page` with a person who reads the page and does what it says.
#include "apps/live/page_server.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <boost/asio/connect.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/write.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>
#include <nlohmann/json.hpp>

#include "apps/live/point_net.h"
#include "recording/data/error.h"
#include "study/streamed_person.h"
#include "tests/apps/child.h"
#include "tests/apps/program.h"

namespace magimu::apps {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
using nlohmann::json;
using testing::AllOf;
using testing::HasSubstr;
using testing::Matches;
using Clock = std::chrono::steady_clock;
using namespace std::chrono_literals;

std::string authority_of(const std::string& url) { return url.substr(7, url.size() - 8); }

asio::ip::tcp::socket connected(asio::io_context& io, const std::string& url) {
  const std::string at = authority_of(url);
  const auto port = std::uint16_t(std::stoi(at.substr(at.rfind(':') + 1)));
  asio::ip::tcp::socket socket(io);
  socket.connect({asio::ip::make_address("127.0.0.1"), port});
  return socket;
}

struct Reply {
  int status = 0;
  std::string body, type;
};

Reply get(const std::string& url, const std::string& target, const std::string& host = "",
          const std::string& origin = "", http::verb verb = http::verb::get) {
  asio::io_context io;
  asio::ip::tcp::socket socket = connected(io, url);
  http::request<http::empty_body> request(verb, target, 11);
  request.set(http::field::host, host.empty() ? authority_of(url) : host);
  if (!origin.empty()) request.set(http::field::origin, origin);
  http::write(socket, request);
  beast::flat_buffer buffer;
  http::response<http::string_body> response;
  http::read(socket, buffer, response);
  return {int(response.result_int()), response.body(),
          std::string(response[http::field::content_type])};
}

// As the page's script is one.
class Browser {
 public:
  explicit Browser(const std::string& url, const std::string& origin = "")
      : socket_(connected(io_, url)) {
    socket_.set_option(beast::websocket::stream_base::decorator([&](auto& request) {
      request.set(http::field::origin, origin.empty() ? "http://" + authority_of(url) : origin);
    }));
    socket_.handshake(authority_of(url), "/live");
  }
  json next() {
    beast::flat_buffer buffer;
    socket_.read(buffer);
    return json::parse(beast::buffers_to_string(buffer.data()));
  }
  // Without a word, as when a cable is pulled and plugged in elsewhere.
  void vanish() {
    socket_.next_layer().set_option(asio::socket_base::linger(true, 0));
    socket_.next_layer().close();
  }

 private:
  asio::io_context io_;
  beast::websocket::stream<asio::ip::tcp::socket> socket_;
};

PageAddress any_port() { return parse_page_address("0"); }

TEST(PageServer, gives_the_page_and_nothing_else) {
  const PageServer server(any_port(), "<html>the page</html>");
  const Reply page = get(server.url(), "/");
  EXPECT_EQ(page.status, 200);
  EXPECT_EQ(page.body, "<html>the page</html>");
  EXPECT_THAT(page.type, HasSubstr("text/html"));
  EXPECT_EQ(get(server.url(), "/../etc/passwd").status, 404);
  EXPECT_EQ(get(server.url(), "/", "", "", http::verb::delete_).status, 405);
}

TEST(PageServer, tells_a_browser_how_things_stand_and_then_what_is_new) {
  PageServer server(any_port(), "");
  server.publish(PageServer::kState, R"({"n": 1})");
  Browser browser(server.url());
  EXPECT_EQ(browser.next()["n"], 1);
  server.publish(PageServer::kTick, R"({"n": 2})");
  EXPECT_EQ(browser.next()["n"], 2);
  EXPECT_EQ(server.browsers(), 1);
}

TEST(PageServer, does_not_wait_for_a_browser_that_does_not_read) {
  PageServer server(any_port(), "");
  Browser slow(server.url());
  ASSERT_TRUE(test::eventually([&] { return server.browsers() == 1; }));
  // 300 MB, were they kept.
  constexpr int kMessages = 3000;
  const std::string filling(100000, 'x');
  const auto begin = Clock::now();
  for (int n = 1; n <= kMessages; ++n) {
    server.publish(PageServer::kState, fmt::format(R"({{"n": {}, "filling": "{}"}})", n, filling));
  }
  EXPECT_LT(Clock::now() - begin, 10s);
  int read = 0, last = 0;
  while (last < kMessages) {
    const int n = slow.next()["n"];
    EXPECT_GT(n, last);
    last = n;
    ++read;
  }
  EXPECT_LT(read, kMessages / 2);  // what the buffers of the sockets hold, and the newest
}

TEST(PageServer, forgets_a_browser_that_has_gone) {
  PageServer server(any_port(), "");
  {
    Browser gone(server.url()), stays(server.url());
    ASSERT_TRUE(test::eventually([&] { return server.browsers() == 2; }));
    gone.vanish();
    EXPECT_TRUE(test::eventually([&] { return server.browsers() == 1; }));
    server.publish(PageServer::kState, R"({"n": 7})");
    EXPECT_EQ(stays.next()["n"], 7);
    stays.vanish();
  }
  EXPECT_TRUE(test::eventually([&] { return server.browsers() == 0; }));
}

TEST(PageServer, is_not_for_pages_of_other_sites) {
  const PageServer server(any_port(), "");
  EXPECT_EQ(get(server.url(), "/", "evil.example:80").status, 403);  // a name that points here
  EXPECT_EQ(get(server.url(), "/", "", "http://evil.example").status, 403);
  EXPECT_THROW(Browser(server.url(), "http://evil.example"), boost::system::system_error);
  EXPECT_EQ(get(server.url(), "/", "localhost").status, 200);
}

TEST(PageServer, endures_bytes_that_are_no_request) {
  PageServer server(any_port(), "still here");
  asio::io_context io;
  for (const std::string& bytes :
       {std::string("\0\xff\x16\x03", 4), std::string("GET / HTTP/1.1\r\nHost: "),
        "GET / HTTP/1.1\r\nX: " + std::string(100000, 'y'), std::string("\r\n\r\n\r\n")}) {
    asio::ip::tcp::socket socket = connected(io, server.url());
    boost::system::error_code ignored;
    asio::write(socket, asio::buffer(bytes), ignored);
  }
  EXPECT_EQ(get(server.url(), "/").body, "still here");
}

TEST(PageServer, takes_the_next_port_unless_one_was_asked_for) {
  const PageServer first(parse_page_address(""), ""), second(parse_page_address(""), "");
  EXPECT_NE(first.url(), second.url());
  const std::string taken = authority_of(first.url());
  EXPECT_THROW(PageServer(parse_page_address(taken.substr(taken.rfind(':') + 1)), ""), InputError);
}

TEST(PageAddress, is_a_port_or_an_address_with_one) {
  EXPECT_EQ(parse_page_address("9000").port, 9000);
  EXPECT_EQ(parse_page_address("9000").host, "127.0.0.1");
  EXPECT_EQ(parse_page_address("0.0.0.0:81").host, "0.0.0.0");
  EXPECT_EQ(parse_page_address("[::1]:81").host, "::1");
  EXPECT_EQ(parse_page_address("").port, kPagePort);
  for (const char* text : {"x", "70000", "host:80", "1.2.3.4:", ":80", "-1", "80 "}) {
    EXPECT_THROW(parse_page_address(text), InputError) << text;
  }
}

TEST(PointNet, keeps_a_few_hundred_points_everywhere_however_many_come) {
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal;
  PointNet net(600);
  for (int k = 0; k < 5000; ++k) {
    Vector3 v(normal(random), normal(random), normal(random));
    v.normalize();
    if (k % 5 != 0 && v[2] < 0.6) continue;  // mostly near one pole
    net.add(48.0 * v);
  }
  EXPECT_LE(net.points().size(), 600U);
  EXPECT_GE(net.points().size(), 200U);
  int below = 0;
  for (const Vector3& p : net.points()) below += p[2] < 0.0 ? 1 : 0;
  EXPECT_NEAR(double(below) / double(net.points().size()), 0.5, 0.12);
}

TEST(PointNet, follows_a_field_that_has_changed_and_ignores_what_is_no_number) {
  PointNet net(100);
  for (int k = 0; k < 1000; ++k) net.add(Vector3(std::cos(0.1 * k), std::sin(0.1 * k), 0.0));
  const std::size_t before = net.points().size();
  net.add(Vector3(NAN, 0.0, 0.0));
  EXPECT_EQ(net.points().size(), before);
  net.add(Vector3(30.0, 0.0, 0.0));
  EXPECT_THAT(net.points(), testing::Contains(Vector3(30.0, 0.0, 0.0)));
}

// Reads the page, turns the board as it says, and sends what the sensors read.
class GuidedStream : public testing::Test {
 protected:
  static std::string row(const StreamSample& s) {
    std::string out = fmt::format("{}", s.t);
    for (const Vector3* v : {&*s.acc, &*s.gyr, &*s.mag.front()}) {
      out += fmt::format(",{},{},{}", (*v)[0], (*v)[1], (*v)[2]);
    }
    return out + "\n";
  }
  std::string url() const {
    const std::string errors = magimu_.text(".err"), before = "the page is at ";
    const std::size_t at = errors.find(before);
    if (at == std::string::npos || errors.find('\n', at) == std::string::npos) return "";
    return errors.substr(at + before.size(), errors.find('\n', at) - at - before.size());
  }

  test::Program magimu_;
};

TEST_F(GuidedStream, leads_a_person_from_the_first_sample_to_good_enough) {
  test::Child child(magimu_.folder(), {"stream", "-", "--page", "0", "-o", "cal.json"});
  ASSERT_TRUE(test::eventually([&] { return !url().empty(); }));
  EXPECT_THAT(get(url(), "/").body, HasSubstr("<canvas"));
  Browser browser(url());
  StreamedPerson person(11);
  std::string rows = "t,acc_x,acc_y,acc_z,gyr_x,gyr_y,gyr_z,mag_x,mag_y,mag_z\n";
  double t = 0.0;
  const auto send = [&](const StreamSample& s) {
    rows += row(s);
    t = s.t;
    return false;
  };
  json state;
  // What the page shows once it has all that was sent.
  const auto look = [&] {
    child.send(rows);
    rows.clear();
    for (;;) {
      const json told = browser.next();
      if (told["kind"] != "state" || told["line"].is_null()) continue;
      state = told;
      if (double(state["line"]["t"]) > t - 1.05) return state["line"]["phase"] == "converged";
    }
  };
  person.turn(Vector3::Zero(), 3.0, send);
  std::size_t most_points = 0, looks = 0;
  while (!look() && t < 200.0) {
    ++looks;
    most_points = std::max(most_points, state["points"].size());
    const std::string guidance = state["line"]["guidance"];
    const Vector3 axis = axis_of(guidance);
    person.turn(axis, axis.isZero() ? 3.0 : angle_of(guidance), send);
  }
  EXPECT_EQ(state["line"]["phase"], "converged") << "after " << t << " s";
  EXPECT_GT(looks, 1U);
  EXPECT_GT(most_points, 20U);
  EXPECT_LE(state["points"].size(), 600U);
  EXPECT_LE(double(state["line"]["target"][0]["sigma"]), 0.5);
  child.close_input();
  while (!state.contains("end")) {
    const json told = browser.next();
    if (told["kind"] == "state") state = told;
  }
  EXPECT_NE(state["end"]["verdict"], "no");
  EXPECT_EQ(state["end"]["file"], "cal.json");
  EXPECT_EQ(child.wait(), kDone);
  const json file = magimu_.json("cal.json");
  EXPECT_EQ(state["end"]["magnetometers"], file["magnetometers"]);
  EXPECT_THAT(file["provenance"]["command"], HasSubstr("stream - --page 0"));
}

TEST_F(GuidedStream, names_a_fault_before_there_is_a_window) {
  test::Child child(magimu_.folder(), {"stream", "-", "--page", "0"});
  ASSERT_TRUE(test::eventually([&] { return !url().empty(); }));
  Browser browser(url());
  StreamedPerson person(5);
  std::string rows = "t,acc_x,acc_y,acc_z,gyr_x,gyr_y,gyr_z,mag_x,mag_y,mag_z\n";
  person.turn(Vector3::UnitX(), 6.0, [&](StreamSample s) {
    *s.mag.front() *= 1000.0;  // nT
    rows += row(s);
    return false;
  });
  child.send(rows);
  json told = browser.next();
  while (told["kind"] != "tick" || told["fatal"] != true) told = browser.next();
  EXPECT_EQ(told["headline"], "Wrong unit");
  EXPECT_THAT(std::string(told["guidance"]), HasSubstr("--unit mag=nT"));
}

TEST_F(GuidedStream, is_drawn_by_a_browser) {
  if (std::system("command -v chromium >/dev/null 2>&1") != 0) {
    GTEST_SKIP() << "chromium is not installed";
  }
  ASSERT_EQ(magimu_("simulate -q -o rec.csv --motion hand --rate 50 --duration 60").exit_code,
            kDone);
  magimu_.folder().write(".err", "");
  test::Child child(magimu_.folder(), {"stream", "-", "--page", "0"});
  ASSERT_TRUE(test::eventually([&] { return !url().empty(); }));
  child.send(magimu_.text("rec.csv"));
  Browser browser(url());
  for (json told;
       told["kind"] != "state" || told["line"].is_null() || told["line"]["phase"] != "converged";) {
    told = browser.next();
  }
  const std::string page = magimu_.folder().path("dom.html");
  // The budget is of the page's own clock, which does not wait for what comes over a socket: the
  // page may be drawn before its state has come, or when the socket has just been closed.
  const auto shows_all = AllOf(HasSubstr(">good enough</span>"),
                               HasSubstr(" % of all directions seen"), HasSubstr("Hard iron"));
  std::string drawn;
  for (int budget = 4000; budget <= 64000 && !Matches(shows_all)(drawn); budget *= 2) {
    const std::string command =
        "timeout 60 chromium --headless --no-sandbox --disable-gpu --virtual-time-budget=" +
        std::to_string(budget) + " --dump-dom " + url() + " >'" + page + "' 2>/dev/null";
    ASSERT_EQ(std::system(command.c_str()), 0);
    drawn = magimu_.text("dom.html");
  }
  EXPECT_THAT(drawn, shows_all);
}

TEST_F(GuidedStream, the_source_may_follow_the_option) {
  magimu_.folder().write("rec.csv", "t,acc_x\n");
  const test::Outcome run = magimu_("stream --page rec.csv");
  EXPECT_EQ(run.exit_code, kUnusable);
  EXPECT_THAT(run.err, HasSubstr("the page is at http://127.0.0.1:80"));
}

}  // namespace
}  // namespace magimu::apps
