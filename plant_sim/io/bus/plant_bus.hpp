// SPDX-License-Identifier: Apache-2.0
// The bus with everybody on it, as a study sees it: the plant's frames of a tick go in, what the others sent comes out.
#pragma once
#include <cstdint>
#include <stdexcept>
#include <string>
#include <vector>

#include "can_dbc/lockstep.hpp"
#include "io/bus/frame_sink.hpp"

namespace voltlap::plant {

/// What a harness asks of driver and plant. Nothing by default.
struct Interventions {
  can::DriverOverride driver{};          ///< in force until it changes
  std::vector<can::PlantFault> faults{};  ///< that begin with this tick
};

/// A node whose process is dead or answers no more.
struct LostNode {
  std::string node{};
  bool drives = false;  ///< a control unit: the car cannot go on without it
};

enum class StopAsked { kNo, kInterrupted, kFinished };

/// The bus can no longer be used; the message says why.
class BusFailure : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

class PlantBus {
 public:
  virtual ~PlantBus() = default;
  /// The sink sees every frame of the plant and of the control units, in the order of the bus.
  virtual void attach(FrameSink& sink) = 0;

  /// Begins a tick; what is returned holds until the next call.
  virtual const Interventions& begin_tick(std::uint32_t tick) = 0;
  /// Sends the plant's frames, has the control units answer, and returns what they sent; valid until the next call.
  virtual FrameView exchange(const TxQueue& plant) = 0;

  /// All that were lost so far, in their order.
  [[nodiscard]] virtual const std::vector<LostNode>& lost() const = 0;
  [[nodiscard]] virtual StopAsked stop_asked() const = 0;

  [[nodiscard]] virtual std::uint64_t frames_sent() const = 0;
  [[nodiscard]] virtual std::uint32_t frames_in_tick_max() const = 0;
};

}  // namespace voltlap::plant
