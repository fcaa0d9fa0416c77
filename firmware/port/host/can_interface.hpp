// SPDX-License-Identifier: Apache-2.0
// A raw socket on a CAN interface, opened with reasons: what every reader and writer of a bus begins with.
#pragma once
#include <string>

namespace voltlap::port {

/// Closed with its owner.
class CanDescriptor {
 public:
  /// A socket that is not bound yet, on an interface whose name, kind and state are checked. Throws BusSetupError.
  explicit CanDescriptor(const std::string& interface);
  ~CanDescriptor();
  CanDescriptor(const CanDescriptor&) = delete;
  CanDescriptor& operator=(const CanDescriptor&) = delete;

  [[nodiscard]] int get() const { return socket_; }
  /// From here on frames pass. Throws BusSetupError.
  void bind(const std::string& interface) const;

 private:
  int socket_;
};

[[nodiscard]] std::string quoted(const std::string& interface);

/// Throws BusDownError for an error of a socket that worked; `action`: receive, send.
[[noreturn]] void fail_on_bus(const std::string& interface, int error, const char* action);

}  // namespace voltlap::port
