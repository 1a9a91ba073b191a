// SPDX-License-Identifier: BSD-3-Clause
// Recordings and calibrations as bytes, for Python's pickle and copy: pools of processes hand them
// from one to the other. For the same version on the same machine; what is to be kept is a file.
#pragma once

#include <memory>
#include <string>

#include "python/bindings.h"
#include "recording/data/recording.h"

namespace magimu::python {

std::string bytes_of(const Recording& recording);
// Throws InputError where the bytes are damaged.
Recording recording_from_bytes(const std::string& bytes);

// How a fit went stays behind, but for what its file says of it; motion and residuals come along.
std::string bytes_of(const Fitted& fitted);
std::shared_ptr<Fitted> fitted_from_bytes(const std::string& bytes);

}  // namespace magimu::python
