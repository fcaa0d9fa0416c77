// SPDX-License-Identifier: Apache-2.0
// Why a socket on a CAN interface cannot be used, or can no longer.
#pragma once
#include <stdexcept>

namespace voltlap::port {

/// The interface cannot be opened. The message says what was found and what to do.
class BusSetupError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The interface worked and does no longer: it went down, vanished, is bus-off or takes no frames.
class BusDownError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace voltlap::port
