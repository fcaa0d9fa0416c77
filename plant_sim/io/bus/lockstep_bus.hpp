// SPDX-License-Identifier: Apache-2.0
// The plant's side of the lockstep: SYNC after its frames, then everybody in turn, and the next tick only when all are
// done. A member that is lost gets its DONE from here, so that simulated time goes on without it.
#pragma once
#include <array>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "can_dbc/lockstep.hpp"
#include "io/bus/socket_bus.hpp"
#include "port/host/pacer.hpp"

namespace voltlap::plant {

struct LockstepOptions {
  std::string interface{};
  std::vector<can::Member> members{};
  double lost_after_s = 5.0;     ///< wall time without a DONE
  double ready_within_s = 10.0;  ///< wall time until all members are READY
  double pace = 0.0;             ///< at most this many times real time; 0: as fast as the bus allows
  std::function<bool()> interrupted = [] { return false; };
};

class LockstepBus final : public SocketBus {
 public:
  /// Throws port::BusSetupError.
  explicit LockstepBus(LockstepOptions options);
  ~LockstepBus() override;

  /// Waits until all members are READY; false when interrupted. Throws port::BusSetupError that names who is not.
  [[nodiscard]] bool await_members();
  /// Tells all members that the run is over.
  void stop();

  const Interventions& begin_tick(std::uint32_t tick) override;
  FrameView exchange(const TxQueue& plant) override;
  [[nodiscard]] StopAsked stop_asked() const override { return stop_; }
  [[nodiscard]] BusStatistics statistics() const override;

 private:
  static constexpr std::size_t kMembers = 5;  ///< codes of can::Member

  [[nodiscard]] bool takes_part(can::Member m) const { return present_[static_cast<std::size_t>(m)]; }
  [[nodiscard]] bool is_done(can::Member m) const { return done_[static_cast<std::size_t>(m)]; }
  void set_done(can::Member m) { done_[static_cast<std::size_t>(m)] = true; }
  [[nodiscard]] bool all_done() const;
  [[nodiscard]] can::Member first_missing() const;

  void hear_last_done_only();
  void begin_barrier(const TxQueue& plant);
  void await_barrier();
  void handle(const Frame& frame);
  void mark_done(can::Member member, const can::DoneBms& done);
  void add_done_in_place(std::vector<Frame>& batch);
  void send_done_in_place();
  void drop(can::Member member);
  [[nodiscard]] bool was_lost(can::Member member) const;
  void hear_every_done();
  void queue_requests();
  void send_alive();

  LockstepOptions options_;
  port::SocketCan turn_;
  std::optional<port::Pacer> pacer_;
  std::array<bool, kMembers> present_{}, ready_{}, done_{};
  std::uint64_t announced_ = 0;  ///< frames that the control units say they sent
  std::uint32_t tick_ = 0;
  std::vector<Frame> batch_;
  Interventions now_;
  std::vector<can::DriverOverride> overrides_;  ///< to come
  std::vector<can::PlantFault> faults_;         ///< to come
  StopAsked stop_ = StopAsked::kNo;
  bool running_ = false;
};

}  // namespace voltlap::plant
