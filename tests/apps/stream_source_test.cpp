// SPDX-License-Identifier: BSD-3-Clause
// Where streams come from, each as in life: a file, a growing one, a FIFO, a TCP server, a serial
// port (a pair of pseudo terminals). What is sent arrives, whole and in order; what breaks off is
// said; who is too fast waits, or is told what was lost.
#include "apps/channels/stream_source.h"

#include <gmock/gmock.h>
#include <pty.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <termios.h>
#include <unistd.h>

#include <atomic>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/write.hpp>
#include <fstream>
#include <thread>

#include "tests/recording/test_files.h"

namespace magimu::apps {
namespace {

using namespace std::chrono_literals;
using boost::asio::ip::tcp;
using test::error_of;
using test::TempFolder;
using testing::ElementsAre;
using testing::HasSubstr;
using Kind = Arrival::Kind;

// What arrives until its end, an interruption, nothing for long, or so many bytes.
struct Received {
  std::string bytes;
  long lost = 0;
  Kind last = Kind::kNothing;
};
Received receive(StreamSource& source, std::size_t bytes = std::string::npos,
                 std::chrono::milliseconds patience = 5s) {
  Received out;
  while (out.bytes.size() < bytes) {
    Arrival a = source.next(patience);
    out.last = a.kind;
    out.bytes += a.bytes;
    out.lost += a.lost;
    if (a.kind != Kind::kBytes && a.kind != Kind::kLost) break;
  }
  return out;
}

std::string numbered_lines(int n) {
  std::string out;
  for (int i = 0; i < n; ++i) out += std::to_string(i) + "\n";
  return out;
}

class Server {
 public:
  Server() : acceptor_(io_, tcp::endpoint(boost::asio::ip::make_address("127.0.0.1"), 0)) {}
  std::string address() const {
    return "tcp://127.0.0.1:" + std::to_string(acceptor_.local_endpoint().port());
  }
  // Serves one client, then hangs up.
  void serve(const std::string& text) {
    tcp::socket socket = acceptor_.accept();
    boost::asio::write(socket, boost::asio::buffer(text));
  }

 private:
  boost::asio::io_context io_;
  tcp::acceptor acceptor_;
};

class PseudoTerminal {
 public:
  PseudoTerminal() {
    if (::openpty(&master_, &slave_, name_, nullptr, nullptr) != 0) throw std::runtime_error("pty");
    termios raw{};
    ::tcgetattr(slave_, &raw);
    ::cfmakeraw(&raw);
    ::tcsetattr(slave_, TCSANOW, &raw);
  }
  ~PseudoTerminal() {
    unplug();
    ::close(slave_);
  }
  std::string address() const { return std::string("serial:") + name_ + "@115200"; }
  void send(const std::string& text) const {
    for (std::size_t at = 0; at < text.size();) {
      const ssize_t n = ::write(master_, text.data() + at, text.size() - at);
      ASSERT_GT(n, 0);
      at += std::size_t(n);
    }
  }
  // Until the other side has read all of it, which takes long where many tests run at once.
  void wait_until_read() const {
    int quiet = 0, waiting = 0;
    for (int i = 0; i < 1000 && quiet < 10; ++i) {
      std::this_thread::sleep_for(10ms);
      ASSERT_EQ(::ioctl(slave_, FIONREAD, &waiting), 0);
      quiet = waiting == 0 ? quiet + 1 : 0;
    }
  }
  void unplug() {
    if (master_ >= 0) ::close(master_);
    master_ = -1;
  }

 private:
  int master_ = -1, slave_ = -1;
  char name_[256] = {};
};

TEST(StreamAddress, is_read_as_it_is_written) {
  EXPECT_EQ(parse_stream_address("-").kind, StreamAddress::Kind::kStandardInput);
  EXPECT_EQ(parse_stream_address("a/rec.csv").path, "a/rec.csv");
  const StreamAddress tcp = parse_stream_address("tcp://host.lan:5000");
  EXPECT_EQ(tcp.host + " " + tcp.port, "host.lan 5000");
  EXPECT_EQ(parse_stream_address("tcp://[fe80::1]:5000").host, "fe80::1");
  const StreamAddress serial = parse_stream_address("serial:/dev/ttyUSB0@921600");
  EXPECT_EQ(serial.path, "/dev/ttyUSB0");
  EXPECT_EQ(serial.baud, 921600u);
  EXPECT_EQ(parse_stream_address("serial:/dev/ttyACM0").baud, 115200u);
}

TEST(StreamAddress, is_refused_where_it_makes_no_sense) {
  for (const char* text : {"tcp://host", "tcp://host:port", "tcp://:5000", "tcp://h:99999",
                           "serial:", "serial:/dev/ttyUSB0@fast", "serial:/dev/x@0", "udp://h:1"}) {
    EXPECT_THAT(error_of([&] { parse_stream_address(text); }).remedy,
                testing::AnyOf(HasSubstr("write "), HasSubstr("give ")))
        << text;
  }
}

class StreamSourceTest : public testing::Test {
 protected:
  StreamSource& open(const std::string& address) {
    source_.emplace(parse_stream_address(address), options_);
    return *source_;
  }

  TempFolder folder_;
  StreamSourceOptions options_{.retry = 20ms};
  std::optional<StreamSource> source_;
};

TEST_F(StreamSourceTest, a_file_arrives_whole_and_ends) {
  const std::string text = numbered_lines(300000);  // more than the queue holds
  const Received got = receive(open(folder_.write("rec.csv", text)));
  EXPECT_TRUE(got.bytes == text);
  EXPECT_EQ(got.last, Kind::kEnd);
}

TEST_F(StreamSourceTest, what_cannot_be_opened_is_said_with_its_remedy) {
  const auto message = [&](const std::string& address) {
    return std::string(error_of([&] { receive(open(address)); }).what());
  };
  EXPECT_THAT(message(folder_.path("no.csv")), HasSubstr("No such file"));
  EXPECT_THAT(message(folder_.path("")), HasSubstr("is a folder"));
  EXPECT_THAT(message("serial:/dev/ttyNONE@9600"), HasSubstr("USB serial port"));
  EXPECT_THAT(message("tcp://127.0.0.1:1"), HasSubstr("start the sender first"));
  const PseudoTerminal terminal;
  EXPECT_THAT(message(terminal.address().substr(7, terminal.address().size() - 14)),
              HasSubstr("write serial:/dev/pts/"));
}

TEST_F(StreamSourceTest, a_growing_file_is_followed_until_it_is_deleted) {
  options_.follow = true;
  const std::string path = folder_.write("rec.csv", "one\n");
  StreamSource& source = open(path);
  EXPECT_EQ(receive(source, 4).bytes, "one\n");
  EXPECT_EQ(source.next(200ms).kind, Kind::kNothing);
  std::ofstream(path, std::ios::app) << "two\n";
  EXPECT_EQ(receive(source, 4).bytes, "two\n");
  std::filesystem::remove(path);
  EXPECT_EQ(receive(source).last, Kind::kEnd);
}

TEST_F(StreamSourceTest, a_file_written_anew_is_read_from_its_beginning) {
  options_.follow = true;
  const std::string path = folder_.write("rec.csv", "a long first text\n");
  StreamSource& source = open(path);
  receive(source, 18);
  folder_.write("rec.csv", "short\n");
  EXPECT_EQ(receive(source).last, Kind::kInterrupted);
  EXPECT_EQ(receive(source, 6).bytes, "short\n");
}

TEST_F(StreamSourceTest, a_fifo_ends_with_its_writer) {
  const std::string path = folder_.path("fifo");
  ASSERT_EQ(::mkfifo(path.c_str(), 0600), 0);
  StreamSource& source = open(path);
  EXPECT_EQ(source.next(200ms).kind, Kind::kNothing);  // no writer yet
  const std::string text = numbered_lines(300000);
  std::thread writer([&] { std::ofstream(path) << text; });
  const Received got = receive(source);
  writer.join();
  EXPECT_TRUE(got.bytes == text);
  EXPECT_EQ(got.last, Kind::kEnd);
}

TEST_F(StreamSourceTest, a_followed_fifo_waits_for_the_next_writer) {
  options_.follow = true;
  const std::string path = folder_.path("fifo");
  ASSERT_EQ(::mkfifo(path.c_str(), 0600), 0);
  StreamSource& source = open(path);
  std::ofstream(path) << "one\n";
  EXPECT_EQ(receive(source, 4).bytes, "one\n");
  EXPECT_EQ(receive(source).last, Kind::kInterrupted);
  for (int repeat = 0; repeat < 20; ++repeat) {  // whenever they come and go
    std::ofstream(path) << "two\n";
    std::string got;
    while (got.size() < 4) {
      const Arrival a = source.next(5s);
      ASSERT_NE(a.kind, Kind::kNothing);
      got += a.bytes;
    }
    EXPECT_EQ(got, "two\n");
  }
}

TEST_F(StreamSourceTest, a_sender_that_can_wait_is_made_to_wait) {
  const std::string path = folder_.path("fifo");
  ASSERT_EQ(::mkfifo(path.c_str(), 0600), 0);
  options_.capacity = 1000;
  StreamSource& source = open(path);
  const std::string text = numbered_lines(300000);
  std::atomic<bool> all_written = false;
  std::thread writer([&] {
    std::ofstream(path) << text;
    all_written = true;
  });
  std::this_thread::sleep_for(300ms);
  EXPECT_FALSE(all_written);
  const Received got = receive(source);
  writer.join();
  EXPECT_TRUE(got.bytes == text);
  EXPECT_EQ(got.lost, 0);
}

TEST_F(StreamSourceTest, a_tcp_server_is_connected_to_again) {
  Server server;
  std::thread serving([&] {
    server.serve(numbered_lines(300000));
    server.serve("again\n");
  });
  StreamSource& source = open(server.address());
  const Received first = receive(source);
  EXPECT_TRUE(first.bytes == numbered_lines(300000));
  EXPECT_EQ(first.last, Kind::kInterrupted);
  EXPECT_EQ(receive(source, 6).bytes, "again\n");
  serving.join();
}

TEST_F(StreamSourceTest, a_serial_port_sends_its_bytes_unchanged) {
  PseudoTerminal terminal;
  StreamSource& source = open(terminal.address());
  source.next(100ms);
  const std::string text = "\x03\x11\x13\x1a\r\n\xff tab\t" + numbered_lines(100);
  terminal.send(text);
  EXPECT_EQ(receive(source, text.size()).bytes, text);
  EXPECT_EQ(source.next(100ms).kind, Kind::kNothing);
}

TEST_F(StreamSourceTest, a_serial_port_that_is_unplugged_is_said) {
  PseudoTerminal terminal;
  StreamSource& source = open(terminal.address());
  source.next(100ms);
  terminal.unplug();
  const Arrival a = source.next(5s);
  EXPECT_EQ(a.kind, Kind::kInterrupted);
  EXPECT_THAT(a.sentence, HasSubstr("trying again"));
}

TEST_F(StreamSourceTest, what_a_serial_port_sends_too_fast_is_counted) {
  PseudoTerminal terminal;
  options_.capacity = 1000;
  StreamSource& source = open(terminal.address());
  source.next(100ms);
  const std::string text = numbered_lines(10000);
  terminal.send(text);
  terminal.wait_until_read();
  const Received before = receive(source, 1000);  // room again
  terminal.send("last\n");
  const Received after = receive(source, std::string::npos, 500ms);
  EXPECT_GT(after.lost, 0);
  EXPECT_EQ(before.bytes.size() + after.bytes.size() + std::size_t(after.lost), text.size() + 5);
}

TEST_F(StreamSourceTest, is_ended_at_once_whatever_it_waits_for) {
  const std::string path = folder_.path("fifo");
  ASSERT_EQ(::mkfifo(path.c_str(), 0600), 0);
  const auto begin = std::chrono::steady_clock::now();
  open(path).next(50ms);
  source_.reset();
  EXPECT_LT(std::chrono::steady_clock::now() - begin, 2s);
}

}  // namespace
}  // namespace magimu::apps
