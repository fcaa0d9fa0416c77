// SPDX-License-Identifier: Apache-2.0
// What a board found out about itself before the nodes start, and what they make of it.
#pragma once
#include "app/bms_node.hpp"
#include "app/master_node.hpp"
#include "base/require.hpp"
#include "port/image_check.hpp"
#include "port/second_clock.hpp"

namespace voltlap::examples {

class SelfTest {
 public:
  SelfTest(bool memory_good, std::uint32_t image_residue) : memory_good_(memory_good), residue_(image_residue) {}

  /// Before the first tick. The second comparison reads the residue anew and stands on its own: one changed bit of the
  /// image spoils one of the two.
  void judge(app::BmsNode& node) const {
    if (!memory_good_) node.refuse(can::WaitsFor::kSelfTestMemory);
    if (residue_ != port::kImageWhole) node.refuse(can::WaitsFor::kSelfTestFlash);
    VOLTLAP_REQUIRE(residue_ == port::kImageWhole || node.state().self_test != can::WaitsFor::kNone);
  }
  void judge(app::MasterNode& node) const {
    if (!memory_good_ || residue_ != port::kImageWhole) node.refuse();
    VOLTLAP_REQUIRE(residue_ == port::kImageWhole || node.refused());
  }

 private:
  bool memory_good_;
  volatile std::uint32_t residue_;
};

/// Once a tick: nodes whose ticks are no longer what they seem to be refuse to go on. False on a board without a second
/// oscillator.
inline bool clock_is_lost(port::SecondClock* second) { return second != nullptr && !second->agrees(); }

}  // namespace voltlap::examples
