// SPDX-License-Identifier: Apache-2.0
#include "port/template/memory.hpp"

namespace voltlap::port {
namespace {

constexpr std::uint8_t kUnknown = 0x55;  // not blank, and no record's CRC takes it

}  // namespace

/// FILL 5: with flash, port/flash/flash_nvm.hpp is all of this class; write a port::Flash of your part instead. Another
/// kind of memory (FRAM, EEPROM) keeps what port/nvm.hpp says of a write that is cut off.
bool BoardMemory::prepare() { return false; }

/// Nobody knows what was kept: a BMS latches ConfigInvalid, and asks for the reset button at the vehicle.
void BoardMemory::read(NvmRecord record, std::size_t /*slot*/, std::uint8_t* bytes, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) bytes[i] = record == NvmRecord::kTrips ? kUnknown : 0xFF;
}

NvmResult BoardMemory::write(NvmRecord /*record*/, std::size_t /*slot*/, const std::uint8_t* /*bytes*/,
                             std::size_t /*count*/) {
  return NvmResult::kFailed;
}

NvmResult BoardMemory::step() { return NvmResult::kOk; }

}  // namespace voltlap::port
