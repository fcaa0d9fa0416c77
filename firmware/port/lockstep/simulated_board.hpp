// SPDX-License-Identifier: Apache-2.0
// The rest of a board in lockstep: pins that lead nowhere, for the car's contactors listen to the bus; a memory that
// outlives a reset of the board and ends with the run; a watchdog that runs on simulated time, which stands still while
// the plant computes.
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

/// Every slot has the same room; the memory belongs to the board, which puts it where no start-up clears it.
class RamNvm final : public Nvm {
 public:
  static constexpr std::size_t kSlotBytes = 1536;  ///< the longest record: 144 cells of 10 bytes, head and CRC
  static constexpr std::size_t kSlotsTotal = kNvmRecords * kNvmSlots;
  struct Memory {  ///< all zero when it is new
    bool written[kSlotsTotal];
    std::uint8_t slot[kSlotsTotal][kSlotBytes];
  };

  explicit RamNvm(Memory& memory) : memory_(memory) {}

  bool prepare() override { return true; }
  void read(NvmRecord record, std::size_t slot, std::uint8_t* bytes, std::size_t count) override;
  NvmResult write(NvmRecord record, std::size_t slot, const std::uint8_t* bytes, std::size_t count) override;
  NvmResult step() override { return NvmResult::kOk; }

 private:
  Memory& memory_;
};

class SimulatedWatchdog final : public Watchdog {
 public:
  SimulatedWatchdog(const Clock& clock, Rig& rig) : clock_(clock), rig_(rig) {}

  bool start(Duration timeout) override;
  /// Bites when it comes too late: the run ends, as the board would reset. Counts from the first one, for the plant's
  /// clock does not begin anew when a board does.
  void feed() override;
  [[nodiscard]] bool has_bitten() const override { return false; }

 private:
  const Clock& clock_;
  Rig& rig_;
  Duration timeout_{};
  Instant fed_{};
  bool runs_ = false, fed_once_ = false;
};

}  // namespace voltlap::port
