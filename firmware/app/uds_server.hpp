// SPDX-License-Identifier: Apache-2.0
// Diagnosis of a node (ISO 14229-1): who it is (0x22), what faults it has (0x19), reset and the way into the boot
// loader (0x11, 0x10). It reads the node and never writes it; what would start the node anew is refused while
// contactors are closed.
#pragma once
#include <cstddef>
#include <cstdint>

#include "app/iso_tp.hpp"
#include "base/can_frame.hpp"
#include "base/time.hpp"

namespace voltlap::app {

/// The bits of a node's faults as trouble codes: SAE J2012, P1A00 and on, P1B00 and on. Code k is bit first + k, behind
/// the last one bit 0 and on: a code keeps its meaning when a fault is given a bit below the others.
struct UdsFaults {
  std::uint8_t group = 0;
  std::uint8_t count = 0;
  std::uint8_t first = 0;
};
inline constexpr UdsFaults kBmsFaults{0x1A, 21, 1};     ///< bits of BmsStatus.Faults; IsolationFault is the last code
inline constexpr UdsFaults kMasterFaults{0x1B, 16, 0};  ///< bits of MasterStatus.Faults

struct UdsIdentity {
  const char* software_version = "";  ///< F189: of the project
  const char* image_name = "";        ///< F195: of the image
  UdsFaults faults = kBmsFaults;
};

/// What the node says of itself in this tick.
struct UdsView {
  std::uint32_t faults_now = 0;      ///< one bit each
  std::uint32_t faults_latched = 0;
  bool may_restart = false;          ///< no contactor is closed or about to be
};

enum class UdsRestart : std::uint8_t { kNone = 0, kReset = 1, kBootLoader = 2 };

class UdsServer {
 public:
  UdsServer(std::uint8_t address, const UdsIdentity& identity);

  /// Once a tick, with the frames that the node gets; adds at most IsoTp::kFramesPerTick frames.
  void tick(Instant now, FrameView rx, const UdsView& view, TxQueue& tx);
  /// Asked for and answered: the board restarts now.
  [[nodiscard]] UdsRestart restart() const { return transport_.sending() || !answered_ ? UdsRestart::kNone : restart_; }

 private:
  struct Answer {
    std::uint8_t bytes[IsoTp::kResponseMost] = {};
    std::size_t count = 0;
    bool too_long = false;
    void add(std::uint8_t byte);
    void add_text(const char* text);
  };
  /// 0: answered; else the code of a negative response.
  std::uint8_t serve(const UdsView& view, Answer& out);
  std::uint8_t read_data(Answer& out) const;
  std::uint8_t read_faults(const UdsView& view, Answer& out) const;
  std::uint8_t change_session(const UdsView& view, Answer& out);
  std::uint8_t reset(const UdsView& view, Answer& out);
  std::uint8_t tester_present(Answer& out) const;

  UdsIdentity identity_;
  IsoTp transport_;
  UdsRestart restart_ = UdsRestart::kNone;
  bool answered_ = false;
};

}  // namespace voltlap::app
