// SPDX-License-Identifier: Apache-2.0
// The files that this process has read: none of them is ever written over by a result.
#pragma once
#include <string>

namespace voltlap::plant {

/// Every reader says so when it opens a file.
void note_input(const std::string& path);

/// Throws InputError when `path` names, however it is spelled, a file that was read.
void refuse_input_as_output(const std::string& path);

}  // namespace voltlap::plant
