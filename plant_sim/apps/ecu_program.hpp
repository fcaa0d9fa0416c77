// SPDX-License-Identifier: Apache-2.0
// The control units of a run on one board in another program, in lockstep with this one.
#pragma once
#include <string>

#include "apps/ecu_board.hpp"
#include "apps/firmware_loop.hpp"
#include "io/bus/stream_bus.hpp"
#include "race/report/run_result.hpp"

namespace voltlap::plant {

class EcuProgram {
 public:
  /// Starts it and hands it the car's configuration. Throws InputError that says what to install or to build.
  EcuProgram(const EcuOptions& options, const bms::Config& bms, const master::Config& master);

  [[nodiscard]] StreamBus& bus() { return bus_; }
  [[nodiscard]] bool failed() const { return board_.stream().failed(); }
  /// The run is over. Throws InputError when the program does not end as it should.
  void end() { board_.end(); }
  /// Where the firmware ran and what it took, in lines that end.
  [[nodiscard]] std::string summary() const;
  [[nodiscard]] EcuResult result() const;

 private:
  FirmwareLoop inside_;  ///< for the node that an image does not have
  EcuBoard board_;
  StreamBus bus_;
};

}  // namespace voltlap::plant
