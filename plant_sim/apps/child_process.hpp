// SPDX-License-Identifier: Apache-2.0
// This program, or another, as a process of its own, which ends when its parent does.
#pragma once
#include <sys/types.h>

#include <optional>
#include <string>
#include <vector>

namespace voltlap::plant {

struct ChildProgram {
  std::string path;
  std::vector<std::string> arguments{};  ///< without the name
  std::vector<int> files{};              ///< that it has as 3, 4, ...; of the others it gets the standard three
};

class ChildProcess {
 public:
  /// Starts it; standard input is empty. It is killed when the parent dies, however that comes. One that cannot be
  /// started ends with exit code 127.
  ChildProcess(std::string name, const ChildProgram& program);
  /// Starts this program with these arguments. It gets SIGTERM when the parent dies, however that comes.
  ChildProcess(std::string name, const std::vector<std::string>& arguments);
  /// Kills it when it still runs.
  ~ChildProcess();
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;

  [[nodiscard]] const std::string& name() const { return name_; }
  [[nodiscard]] pid_t pid() const { return pid_; }
  [[nodiscard]] bool runs() const { return !status_; }
  /// True once, when it has ended since the last look.
  [[nodiscard]] bool has_just_ended();
  void signal(int number) const;

  /// Of an ended process: its exit code, nothing when a signal ended it.
  [[nodiscard]] std::optional<int> exit_code() const;
  /// "was killed by signal 9 (Killed)", "ended with exit code 2".
  [[nodiscard]] std::string end_text() const;

 private:
  void start(const ChildProgram& program, const std::string& called, int end_signal);

  std::string name_;
  pid_t pid_ = -1;
  std::optional<int> status_;
};

}  // namespace voltlap::plant
