// SPDX-License-Identifier: Apache-2.0
// This program as a process of its own, which ends when its parent does.
#pragma once
#include <sys/types.h>

#include <optional>
#include <string>
#include <vector>

namespace voltlap::plant {

class ChildProcess {
 public:
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
  std::string name_;
  pid_t pid_ = -1;
  std::optional<int> status_;
};

}  // namespace voltlap::plant
