// SPDX-License-Identifier: Apache-2.0
// `voltlap` drives. What learns and what explains are programs of their own beside it, so that who drives need not
// build them; `voltlap` hands their commands over and names them in its help.
#pragma once
#include <CLI/CLI.hpp>

namespace voltlap::plant {

/// Becomes the program that has the command of this command line; returns when `voltlap` has it itself. Throws
/// InputError when that program is not built.
void hand_over(int argc, char** argv);

/// The way back: becomes `voltlap` for its `log record`.
void hand_record_over(int argc, char** argv);

/// Adds the commands of the other programs, for the help and for the nearest name of a wrong one.
void add_other_commands(CLI::App& app);

/// What a command of another program does, in one line.
[[nodiscard]] const char* what_it_does(const char* command);

}  // namespace voltlap::plant
