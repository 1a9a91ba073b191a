// SPDX-License-Identifier: BSD-3-Clause
// Serves one page over HTTP and sends messages to the browsers that show it, by WebSocket. A thread
// of its own does this: publish() never waits for a browser. A slow browser gets the newest message
// of each kind and skips those in between, so that the memory in use does not grow.
//
//   PageServer server(parse_page_address("8020"), html);
//   server.publish(PageServer::kState, R"({"t": 1.5})");
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <string>

namespace magimu::apps {

struct PageAddress {
  std::string host = "127.0.0.1";
  std::uint16_t port = 0;  // 0: any that is free
  bool strict = true;      // only this port; else the first free one from here on
};

constexpr std::uint16_t kPagePort = 8020;

// "", "PORT", "ADDRESS:PORT" or "[ADDRESS]:PORT"; without a port 8020, or one of the next that is
// free. InputError if it is none of these.
PageAddress parse_page_address(const std::string& text);

class PageServer {
 public:
  // Kinds of messages. Only the newest message of a kind counts.
  enum Kind { kState, kTick, kKinds };

  // InputError where the address cannot be listened on.
  PageServer(const PageAddress& address, const std::string& page);
  ~PageServer();
  PageServer(const PageServer&) = delete;
  PageServer& operator=(const PageServer&) = delete;

  void publish(Kind kind, std::string text);
  int browsers() const;     // number connected at present
  std::string url() const;  // "http://127.0.0.1:8020/"
  // Waits until every browser has what was published, for at most `patience`; then closes.
  void finish(std::chrono::milliseconds patience);

 private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace magimu::apps
