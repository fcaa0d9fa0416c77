// SPDX-License-Identifier: Apache-2.0
// BMS and master controller in this process: the firmware's own nodes behind the interface that a study drives.
#pragma once
#include "app/bms_node.hpp"
#include "app/master_node.hpp"
#include "race/endurance.hpp"

namespace voltlap::plant {

class FirmwareLoop final : public Ecus {
 public:
  /// Both nodes, configured for this car. Throws InputError when the firmware refuses the configuration.
  explicit FirmwareLoop(const VehicleParameters& car);
  FirmwareLoop(const bms::Config& bms, const master::Config& master) : bms_(bms), master_(master) {}

  void bms(Instant now, FrameView rx, TxQueue& tx) override;
  [[nodiscard]] const app::BmsNode& bms_node() const { return bms_; }
  void master(Instant now, FrameView rx, TxQueue& tx) override;

 private:
  app::BmsNode bms_;
  app::MasterNode master_;
};

}  // namespace voltlap::plant
