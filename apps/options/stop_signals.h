// SPDX-License-Identifier: BSD-3-Clause
// Ending on request: the first SIGINT (Ctrl-C), SIGTERM or SIGHUP is only noted, so that the
// program can write its result and end. A second signal ends the program at once.
#pragma once

namespace magimu::apps {

// Begins to watch. SIGHUP stays ignored if it was (nohup). SIGPIPE is ignored, too: a write to a
// pipe without readers then fails with an error.
void watch_stop_signals();
bool stop_requested();

}  // namespace magimu::apps
