// SPDX-License-Identifier: BSD-3-Clause
// The wish to end: the first SIGINT (Ctrl-C), SIGTERM or SIGHUP is noted, so that work can be ended
// with its result written; a second one ends the program at once, as without this.
#pragma once

namespace magimu::apps {

// From now on. SIGHUP stays ignored where it was (nohup). SIGPIPE is ignored, too: who writes to a
// pipe that nobody reads learns it from the write.
void watch_stop_signals();
bool stop_requested();

}  // namespace magimu::apps
