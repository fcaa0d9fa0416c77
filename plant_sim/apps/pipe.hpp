// SPDX-License-Identifier: Apache-2.0
// A pipe to another program; its ends are closed with this object, and not inherited unless they are handed over.
#pragma once
#include <fcntl.h>
#include <unistd.h>

#include <utility>

#include "core/errors.hpp"

namespace voltlap::plant {

class Pipe {
 public:
  Pipe() {
    if (::pipe2(ends_, O_CLOEXEC) != 0) {
      throw InputError("a pipe to another program", "that the system has none left", "two open files more",
                       "End other programs, or raise the limit (ulimit -n)");
    }
  }
  ~Pipe() {
    close_end(0);
    close_end(1);
  }
  Pipe(const Pipe&) = delete;
  Pipe& operator=(const Pipe&) = delete;

  [[nodiscard]] int read_end() const { return ends_[0]; }
  [[nodiscard]] int write_end() const { return ends_[1]; }
  void close_read_end() { close_end(0); }
  void close_write_end() { close_end(1); }

 private:
  void close_end(int end) {
    const int file = std::exchange(ends_[end], -1);
    if (file >= 0) ::close(file);
  }
  int ends_[2] = {-1, -1};
};

}  // namespace voltlap::plant
