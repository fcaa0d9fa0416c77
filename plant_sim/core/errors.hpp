// SPDX-License-Identifier: Apache-2.0
// Errors that a person can mend. The message says where, what was found, what was expected and what to do.
#pragma once
#include <stdexcept>
#include <string>

namespace voltlap::plant {

/// A file, a flag or a value that the program was given cannot be used.
class InputError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;

  /// `where` is "file:line", a flag or a key; each of the other parts is a clause without a full stop.
  InputError(const std::string& where, const std::string& found, const std::string& expected,
             const std::string& what_to_do)
      : std::runtime_error(where + ": found " + found + "; expected " + expected + ". " + what_to_do + ".") {}
};

/// A result file cannot be written.
class OutputError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace voltlap::plant
