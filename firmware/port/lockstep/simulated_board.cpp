// SPDX-License-Identifier: Apache-2.0
#include "port/lockstep/simulated_board.hpp"

#include "base/require.hpp"

namespace voltlap::port {
namespace {

constexpr std::uint8_t kBlank = 0xFF;

std::size_t place_of(NvmRecord record, std::size_t slot) {
  VOLTLAP_REQUIRE(slot < kNvmSlots);
  return static_cast<std::size_t>(record) * kNvmSlots + slot;
}

}  // namespace

void RamNvm::read(NvmRecord record, std::size_t slot, std::uint8_t* bytes, std::size_t count) {
  const std::size_t place = place_of(record, slot);
  const bool known = memory_.written[place] && count <= kSlotBytes;
  for (std::size_t i = 0; i < count; ++i) bytes[i] = known ? memory_.slot[place][i] : kBlank;
}

NvmResult RamNvm::write(NvmRecord record, std::size_t slot, const std::uint8_t* bytes, std::size_t count) {
  if (count > kSlotBytes) return NvmResult::kFailed;
  const std::size_t place = place_of(record, slot);
  for (std::size_t i = 0; i < count; ++i) memory_.slot[place][i] = bytes[i];
  memory_.written[place] = true;
  return NvmResult::kOk;
}

bool SimulatedWatchdog::start(Duration timeout) {
  timeout_ = timeout;
  runs_ = true;
  fed_once_ = false;
  return true;
}

void SimulatedWatchdog::feed() {
  const Instant now = clock_.now();
  if (runs_ && fed_once_ && timeout_ < now - fed_) rig_.end(false);
  fed_ = now;
  fed_once_ = true;
}

}  // namespace voltlap::port
