// SPDX-License-Identifier: BSD-3-Clause
#include "apps/options/stop_signals.h"

#include <csignal>

namespace magimu::apps {
namespace {

volatile std::sig_atomic_t requested = 0;

constexpr int kSignals[] = {SIGINT, SIGTERM, SIGHUP};

void note(int) {
  requested = 1;
  for (const int signal : kSignals) std::signal(signal, SIG_DFL);
}

}  // namespace

void watch_stop_signals() {
  for (const int signal : kSignals) {
    struct sigaction now {};
    ::sigaction(signal, nullptr, &now);
    if (signal == SIGHUP && now.sa_handler == SIG_IGN) continue;
    struct sigaction noting {};
    noting.sa_handler = note;
    noting.sa_flags = SA_RESTART;
    ::sigaction(signal, &noting, nullptr);
  }
  std::signal(SIGPIPE, SIG_IGN);
}

bool stop_requested() { return requested != 0; }

}  // namespace magimu::apps
