// SPDX-License-Identifier: Apache-2.0
// The rest of a board in lockstep: pins that lead nowhere, for the car's contactors listen to the bus; a memory that
// lasts as long as the run; a watchdog that runs on simulated time, which stands still while the plant computes.
#pragma once
#include <cstddef>
#include <cstdint>

#include "port/clock.hpp"
#include "port/gpio.hpp"
#include "port/lockstep/rig.hpp"
#include "port/nvm.hpp"
#include "port/watchdog.hpp"

namespace voltlap::port {

class NoPins final : public Gpio {
 public:
  void set(Drive /*what*/, bool /*on*/) override {}
  [[nodiscard]] bool get(Sense /*what*/) const override { return false; }
};

/// Every slot has the same room; the bytes belong to the board, which says where they lie.
class RamNvm final : public Nvm {
 public:
  static constexpr std::size_t kSlotBytes = 1536;  ///< the longest record: 144 cells of 10 bytes, head and CRC
  static constexpr std::size_t kSlotsTotal = kNvmRecords * kNvmSlots;
  static constexpr std::size_t kBytes = kSlotsTotal * kSlotBytes;

  explicit RamNvm(std::uint8_t (&memory)[kBytes]) : memory_(memory) {}

  bool prepare() override { return true; }
  void read(NvmRecord record, std::size_t slot, std::uint8_t* bytes, std::size_t count) override;
  NvmResult write(NvmRecord record, std::size_t slot, const std::uint8_t* bytes, std::size_t count) override;
  NvmResult step() override { return NvmResult::kOk; }

 private:
  std::uint8_t (&memory_)[kBytes];
  bool written_[kSlotsTotal] = {};
};

class SimulatedWatchdog final : public Watchdog {
 public:
  SimulatedWatchdog(const Clock& clock, Rig& rig) : clock_(clock), rig_(rig) {}

  bool start(Duration timeout) override;
  /// Bites when it comes too late: the run ends, as the board would reset.
  void feed() override;
  [[nodiscard]] bool has_bitten() const override { return false; }

 private:
  const Clock& clock_;
  Rig& rig_;
  Duration timeout_{};
  Instant fed_{};
  bool runs_ = false;
};

}  // namespace voltlap::port
