// SPDX-License-Identifier: Apache-2.0
// Formats of CAN recordings that the field's own packages read (python-can, asammdf; plant_sim/python/voltlap_logs):
// they are made into candump lines once, in a file that is gone with the program.
#pragma once
#include <string>
#include <vector>

#include "io/logs/can/frame_clock.hpp"

namespace voltlap::plant {

struct ForeignRecording {
  std::string candump;             ///< the file of candump lines
  std::string format;              ///< such as "Vector BLF"
  std::string broken;              ///< where the recording breaks off; empty when it does not
  std::vector<CanDefect> skipped;  ///< what of it was no frame, by kind
};

/// Whether the content of a file may be a recording in a format that is not read natively: binary, or the first words
/// of one. A table is not.
[[nodiscard]] bool may_be_foreign(const std::string& path);

/// Reads the file once for the whole program. Throws InputError, which calls a format that is known and not read by its
/// name, and says what is missing when there is no Python.
[[nodiscard]] const ForeignRecording& read_foreign(const std::string& path);

}  // namespace voltlap::plant
