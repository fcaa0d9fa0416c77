// SPDX-License-Identifier: Apache-2.0
#include "port/template/bus.hpp"

namespace voltlap::port {

/// FILL 4: port/stm32/can_timing.hpp works out the bit; can::kBmsRx and can::kMasterRx name what is listened to, can::
/// kMessages all. Models: port/stm32f4/bxcan.cpp, port/stm32g4/fdcan.cpp.
bool BoardBus::init(bool /*has_bms*/, bool /*has_master*/) { return true; }

/// FILL 4: what the interrupt of reception has put into a ring (port/stm32/can_controller.hpp), oldest first.
std::size_t BoardBus::receive(Frame* /*frames*/, std::size_t /*capacity*/) { return 0; }

/// FILL 4: never waits; in order; what is left of the step before is dropped, never sent late.
bool BoardBus::send(const TxQueue& frames) { return frames.size() == 0; }

}  // namespace voltlap::port
