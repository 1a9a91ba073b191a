// SPDX-License-Identifier: BSD-3-Clause
// What `magimu --version` says: the version, and how this binary was built.
#pragma once

#include <string>

namespace magimu::apps {

std::string version_text();
std::string version_number();  // "0.1.0"

}  // namespace magimu::apps
