// SPDX-License-Identifier: Apache-2.0
// Runs one of the project's Python modules (plant_sim/python): what the field has a parser or a writer for in Python is
// done by that. Which Python: $VOLTLAP_PYTHON, else the one that the build was configured with, else python3.
#pragma once
#include <string>
#include <vector>

namespace voltlap::plant {

/// Runs `python -m module arguments...`, without a shell, and gives its standard output. Standard error is kept for the
/// message. Ctrl-C reaches both processes. Throws InputError with the module's own words when it ends with exit code 2
/// (an input that a person can mend), and with the command that installs what is missing when there is no Python or no
/// package; std::runtime_error for every other end.
[[nodiscard]] std::string run_python_module(const std::string& module, const std::vector<std::string>& arguments);

/// The same with the standard output in a file, which is there whole or not at all (AtomicFile).
void run_python_module_into(const std::string& path, const std::string& module,
                            const std::vector<std::string>& arguments);

/// A module that reads or writes recordings, and tells on standard error what it met.
struct PythonReport {
  bool broke_off = false;  ///< the recording ends before its end (exit code 3): what stood before it was read
  std::string words;       ///< standard error
};
struct PythonStreams {
  std::string in{};   ///< file for standard input; empty: none
  std::string out{};  ///< file for standard output, written as it comes; empty: thrown away
};
/// Throws as run_python_module does for every other end.
PythonReport run_recording_module(const std::string& module, const std::vector<std::string>& arguments,
                                  const PythonStreams& streams);

/// The Python that is used, for messages.
[[nodiscard]] std::string python_program();

}  // namespace voltlap::plant
