// SPDX-License-Identifier: BSD-3-Clause
// Is a MAT file of version 5 whole, and are the lengths in it believable? matio takes what is
// missing at the end of a cut file for zeros, and reserves memory for whatever lengths and
// dimensions a variable claims before it looks whether they can be true: a damaged byte may cost
// gigabytes. So this looks first. Internal to recording/.
#pragma once

#include <string_view>

namespace magimu {

// content: the whole file, at least its header of 128 bytes.
bool mat_elements_fit(std::string_view content);

}  // namespace magimu
