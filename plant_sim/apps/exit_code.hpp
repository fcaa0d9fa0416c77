// SPDX-License-Identifier: Apache-2.0
// What the program tells its caller. 4 (packages missing), 5 (the build failed) and 1 of the tests (one failed) come
// from the start script.
#pragma once

namespace voltlap::plant {

inline constexpr int kExitOk = 0;
inline constexpr int kExitDefects = 1;        ///< a recording has defects, or breaks off
inline constexpr int kExitInput = 2;          ///< usage, input, or a result file that cannot be written
inline constexpr int kExitFailedRun = 3;      ///< the car did not make it: an assertion, a trip, an empty battery
inline constexpr int kExitFault = 70;         ///< memory ran out, or a defect of the program
inline constexpr int kExitInterrupted = 130;  ///< Ctrl-C; other signals that ask a run to end give 128 and their number

}  // namespace voltlap::plant
