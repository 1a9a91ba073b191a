// SPDX-License-Identifier: BSD-3-Clause
#include "apps/live/page_server.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>
#include <charconv>
#include <condition_variable>
#include <deque>
#include <functional>
#include <mutex>
#include <optional>
#include <set>
#include <thread>

#include "recording/data/error.h"

namespace magimu::apps {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using tcp = asio::ip::tcp;
using Failure = boost::system::error_code;
using Text = std::shared_ptr<const std::string>;
using Texts = std::array<Text, PageServer::kKinds>;
using namespace std::chrono_literals;

constexpr std::size_t kMostBrowsers = 32;
constexpr std::size_t kMostHeader = 16384, kMostSaid = 1024;  // bytes, of a request; of a message
constexpr auto kPatience = 10s;                               // until a request must be complete
constexpr int kPortsTried = 20;

struct Request {
  bool get = false, upgrade = false;
  std::string target, host, origin;
};

// "localhost:8020" -> "localhost"
std::string without_port(std::string_view host) {
  const std::size_t colon = host.rfind(':');
  if (colon != std::string_view::npos && host.find(']', colon) == std::string_view::npos) {
    host = host.substr(0, colon);
  }
  return std::string(host);
}

bool is_loopback_name(const std::string& host) {
  return host == "localhost" || host == "127.0.0.1" || host == "[::1]";
}

// What all connections share. Used by the server's thread only, except for the atomic counter.
struct Shared {
  std::string page;
  bool loopback = true;
  Texts latest;
  std::set<class Connection*> open;
  std::atomic<int> browsers = 0;

  // Pages of other sites may not listen here, even if their own name resolves to this machine (DNS
  // rebinding).
  bool may(const Request& r) const {
    if (loopback && !is_loopback_name(without_port(r.host))) return false;
    return r.origin.empty() || r.origin == "http://" + r.host;
  }
};

// One browser: its request for the page, or its WebSocket.
class Connection : public std::enable_shared_from_this<Connection> {
 public:
  Connection(tcp::socket&& socket, Shared& shared) : shared_(shared), stream_(std::move(socket)) {
    shared_.open.insert(this);
  }
  ~Connection() {
    shared_.open.erase(this);
    if (counted_) --shared_.browsers;
  }

  void start() {
    parser_.emplace();
    parser_->header_limit(kMostHeader);
    parser_->body_limit(0);
    stream_.expires_after(kPatience);
    http::async_read(stream_, buffer_, *parser_,
                     [self = shared_from_this()](Failure failed, std::size_t) {
                       if (!failed) self->answer();
                     });
  }

  void tell(int kind, const Text& text) {
    if (!socket_ || !counted_) return;
    waiting_[std::size_t(kind)] = text;
    write_next();
  }
  void close() {
    if (counted_) {
      closing_ = true;
      return write_next();
    }
    tcp::socket& plain = socket_ ? beast::get_lowest_layer(*socket_).socket() : stream_.socket();
    beast::error_code ignored;
    plain.shutdown(tcp::socket::shutdown_both, ignored);
  }

 private:
  void answer() {
    const auto& message = parser_->get();
    Request request;
    request.get = message.method() == http::verb::get || message.method() == http::verb::head;
    request.upgrade = websocket::is_upgrade(message);
    request.target = std::string(message.target());
    request.host = std::string(message[http::field::host]);
    request.origin = std::string(message[http::field::origin]);
    if (!shared_.may(request)) return respond(http::status::forbidden, "not for other sites\n");
    if (!request.get) return respond(http::status::method_not_allowed, "GET only\n");
    if (request.target == "/live" && request.upgrade) return accept();
    if (request.target == "/") return respond(http::status::ok, shared_.page);
    if (request.target == "/favicon.ico") return respond(http::status::no_content, "");
    respond(http::status::not_found, "there is one page here: /\n");
  }

  void respond(http::status status, const std::string& body) {
    const bool page = status == http::status::ok;
    response_.emplace(status, parser_->get().version());
    response_->set(http::field::content_type,
                   page ? "text/html; charset=utf-8" : "text/plain; charset=utf-8");
    response_->set(http::field::cache_control, "no-store");
    response_->set("X-Content-Type-Options", "nosniff");
    response_->set("X-Frame-Options", "DENY");
    response_->keep_alive(false);
    response_->body() = parser_->get().method() == http::verb::head ? std::string() : body;
    response_->prepare_payload();
    stream_.expires_after(kPatience);
    http::async_write(stream_, *response_, [self = shared_from_this()](Failure, std::size_t) {
      beast::error_code ignored;
      self->stream_.socket().shutdown(tcp::socket::shutdown_send, ignored);
    });
  }

  void accept() {
    if (shared_.browsers >= int(kMostBrowsers)) {
      return respond(http::status::service_unavailable, "too many browsers\n");
    }
    stream_.expires_never();  // the WebSocket's own timeouts from here on
    socket_.emplace(std::move(stream_));
    // A silent browser is asked whether it is still there, and given up if it does not answer.
    socket_->set_option(websocket::stream_base::timeout{kPatience, 30s, true});
    socket_->read_message_max(kMostSaid);
    socket_->async_accept(parser_->get(), [self = shared_from_this()](Failure failed) {
      if (failed) return;
      self->counted_ = true;
      ++self->shared_.browsers;
      self->listen();
      self->waiting_ = self->shared_.latest;
      self->write_next();
    });
  }

  // What a browser sends is ignored. Reading is how a closed connection is noticed.
  void listen() {
    buffer_.consume(buffer_.size());
    socket_->async_read(buffer_, [self = shared_from_this()](Failure failed, std::size_t) {
      if (!failed) self->listen();
    });
  }

  void write_next() {
    if (writing_) return;
    const auto next = std::ranges::find_if(waiting_, [](const Text& t) { return t != nullptr; });
    if (next == waiting_.end()) {
      if (closing_) end();
      return;
    }
    being_written_ = std::exchange(*next, nullptr);
    writing_ = true;
    socket_->text(true);
    socket_->async_write(asio::buffer(*being_written_),
                         [self = shared_from_this()](Failure failed, std::size_t) {
                           self->writing_ = false;
                           self->being_written_ = nullptr;
                           if (failed) {
                             self->waiting_ = {};
                           } else {
                             self->write_next();
                           }
                         });
  }

  void end() {
    writing_ = true;  // so that no further write begins
    socket_->async_close(websocket::close_code::going_away,
                         [self = shared_from_this()](Failure) {});
  }

  Shared& shared_;
  beast::tcp_stream stream_;
  beast::flat_buffer buffer_{kMostHeader + kMostSaid};
  std::optional<http::request_parser<http::empty_body>> parser_;
  std::optional<http::response<http::string_body>> response_;
  std::optional<websocket::stream<beast::tcp_stream>> socket_;
  Texts waiting_;
  Text being_written_;
  bool counted_ = false, writing_ = false, closing_ = false;
};

}  // namespace

PageAddress parse_page_address(const std::string& text) {
  const auto refuse = [&text] {
    return InputError("--page", 0, 0, fmt::format("\"{}\" is no port and no ADDRESS:PORT", text),
                      "give a port such as 8020, or 0.0.0.0:8020 to be seen from other machines");
  };
  PageAddress out;
  if (text.empty()) {
    out.port = kPagePort;
    out.strict = false;
    return out;
  }
  std::string port = text;
  if (const std::size_t colon = text.rfind(':'); colon != std::string::npos) {
    out.host = text.substr(0, colon);
    port = text.substr(colon + 1);
    if (out.host.starts_with("[") && out.host.ends_with("]")) {
      out.host = out.host.substr(1, out.host.size() - 2);
    }
  }
  if (out.host == "localhost") out.host = "127.0.0.1";
  const char* end = port.data() + port.size();
  const auto parsed = std::from_chars(port.data(), end, out.port);
  Failure failed;
  asio::ip::make_address(out.host, failed);
  if (parsed.ec != std::errc() || parsed.ptr != end || failed) throw refuse();
  return out;
}

class PageServer::Implementation {
 public:
  Implementation(const PageAddress& address, const std::string& page) : acceptor_(io_) {
    shared_.page = page;
    open(address);
    shared_.loopback = acceptor_.local_endpoint().address().is_loopback();
    accept();
    thread_ = std::thread([this] { io_.run(); });
  }

  ~Implementation() {
    io_.stop();
    thread_.join();
  }

  // Only the newest message of a kind matters: one that the thread has not sent yet is replaced.
  void publish(Kind kind, std::string text) {
    auto shared_text = std::make_shared<const std::string>(std::move(text));
    {
      const std::lock_guard lock(mutex_);
      inbox_[kind] = std::move(shared_text);
      if (std::exchange(posted_, true)) return;
    }
    asio::post(io_, [this] { take_inbox(); });
  }

  int browsers() const { return shared_.browsers; }

  std::string url() const {
    const tcp::endpoint at = acceptor_.local_endpoint();
    const std::string host = at.address().to_string();
    return at.address().is_v6() ? fmt::format("http://[{}]:{}/", host, at.port())
                                : fmt::format("http://{}:{}/", host, at.port());
  }

  void finish(std::chrono::milliseconds patience) {
    const auto end = std::chrono::steady_clock::now() + patience;
    asio::post(io_, [this] {
      take_inbox();
      for (Connection* c : shared_.open) c->close();
    });
    while (browsers() > 0 && std::chrono::steady_clock::now() < end) {
      std::this_thread::sleep_for(5ms);
    }
  }

 private:
  void open(const PageAddress& address) {
    const asio::ip::address host = asio::ip::make_address(address.host);
    Failure failed;
    for (int i = 0; i < (address.strict ? 1 : kPortsTried); ++i) {
      const tcp::endpoint endpoint(host, std::uint16_t(address.port + i));
      failed = {};
      if (acceptor_.is_open()) acceptor_.close();
      acceptor_.open(endpoint.protocol(), failed);
      if (!failed) acceptor_.set_option(asio::socket_base::reuse_address(true), failed);
      if (!failed) acceptor_.bind(endpoint, failed);
      if (!failed) acceptor_.listen(asio::socket_base::max_listen_connections, failed);
      if (!failed) return;
    }
    throw InputError("--page", 0, 0,
                     fmt::format("{}:{} cannot be listened on: {}", address.host, address.port,
                                 failed.message()),
                     "give another port, or 0 for any that is free");
  }

  void accept() {
    acceptor_.async_accept([this](Failure failed, tcp::socket socket) {
      if (!failed && shared_.open.size() < 2 * kMostBrowsers) {
        std::make_shared<Connection>(std::move(socket), shared_)->start();
      } else if (failed) {
        // For example, there is no descriptor left: wait before the next try.
        pause_.expires_after(100ms);
        pause_.async_wait([this](Failure) { accept(); });
        return;
      }
      accept();
    });
  }

  void take_inbox() {
    Texts inbox;
    {
      const std::lock_guard lock(mutex_);
      inbox = std::exchange(inbox_, {});
      posted_ = false;
    }
    for (int kind = 0; kind < kKinds; ++kind) {
      const Text& text = inbox[std::size_t(kind)];
      if (!text) continue;
      shared_.latest[std::size_t(kind)] = text;
      for (Connection* c : shared_.open) c->tell(kind, text);
    }
  }

  Shared shared_;  // outlives the connections, which the context's handlers hold
  asio::io_context io_{1};
  tcp::acceptor acceptor_;
  asio::steady_timer pause_{io_};
  std::mutex mutex_;
  Texts inbox_;
  bool posted_ = false;
  std::thread thread_;
};

PageServer::PageServer(const PageAddress& address, const std::string& page)
    : implementation_(std::make_unique<Implementation>(address, page)) {}
PageServer::~PageServer() = default;
void PageServer::publish(Kind kind, std::string text) {
  implementation_->publish(kind, std::move(text));
}
int PageServer::browsers() const { return implementation_->browsers(); }
std::string PageServer::url() const { return implementation_->url(); }
void PageServer::finish(std::chrono::milliseconds patience) { implementation_->finish(patience); }

}  // namespace magimu::apps
