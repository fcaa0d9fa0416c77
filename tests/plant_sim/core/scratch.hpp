// SPDX-License-Identifier: Apache-2.0
// Files for one test, and the message of the error that a call is expected to end with.
#pragma once
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "core/errors.hpp"

/// A folder of its own that is gone after the test.
class Scratch {
 public:
  Scratch() {
    std::string pattern = (std::filesystem::temp_directory_path() / "voltlap-test-XXXXXX").string();
    path_ = ::mkdtemp(pattern.data());
  }
  ~Scratch() { std::filesystem::remove_all(path_); }
  Scratch(const Scratch&) = delete;
  Scratch& operator=(const Scratch&) = delete;

  [[nodiscard]] std::string file(const std::string& name) const { return (path_ / name).string(); }
  std::string write(const std::string& name, const std::string& text) const {
    std::ofstream(file(name)) << text;
    return file(name);
  }
  [[nodiscard]] std::size_t files() const {
    return static_cast<std::size_t>(std::distance(std::filesystem::directory_iterator(path_), {}));
  }

 private:
  std::filesystem::path path_;
};

/// What the call complains of; "no error" when it does not.
template <class Call>
std::string complaint(const Call& call) {
  try {
    call();
  } catch (const voltlap::plant::InputError& error) {
    return error.what();
  } catch (const voltlap::plant::OutputError& error) {
    return error.what();
  }
  return "no error";
}
