// SPDX-License-Identifier: Apache-2.0
// The seam to a reset that the node itself asks for.
#pragma once

namespace voltlap::port {

class Restart {
 public:
  /// Outputs off, then a reset of the processor. `into_boot_loader`: with a request for the boot loader behind the
  /// reset to stay (base/boot_request.hpp), where the board has one; without one, as any other.
  [[noreturn]] virtual void restart(bool into_boot_loader) = 0;

 protected:
  ~Restart() = default;
};

}  // namespace voltlap::port
