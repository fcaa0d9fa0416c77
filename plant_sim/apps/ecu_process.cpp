// SPDX-License-Identifier: Apache-2.0
#include "apps/ecu_process.hpp"

#include <fmt/format.h>

#include <array>
#include <cstdio>
#include <deque>

#include "apps/exit_code.hpp"
#include "apps/run_recorder.hpp"
#include "can_dbc/tables.hpp"
#include "core/demand.hpp"
#include "port/host/lockstep_member.hpp"
#include "port/host/pacer.hpp"
#include "port/host/silence.hpp"

namespace voltlap::plant {
namespace {

using port::Wake;

constexpr double kSilence_s = 2.0;            // the plant shows life every 0.5 s, however slow the run
constexpr std::uint32_t kAlone_ticks = 500;   // 5 s: contactors open and faults stand long before
constexpr std::size_t kFramesMax = 512;       // 5 times what 500 kbit/s carries in a tick; more is lost
constexpr std::int64_t kTick_us = can::kTickMs * 1000;

/// A node with its inbox.
class Runner {
 public:
  explicit Runner(EcuNode node) : node_(std::move(node)) {}

  [[nodiscard]] const EcuNode& node() const { return node_; }
  const TxQueue& step(Instant now, port::Can& can) {
    const std::size_t count = can.receive(inbox_.data(), inbox_.size());
    for (std::array<Frame, 64> beyond; count == inbox_.size() && can.receive(beyond.data(), beyond.size()) > 0;) {
    }
    tx_.clear();
    node_.tick(now, {inbox_.data(), count}, tx_);
    return tx_;
  }

 private:
  EcuNode node_;
  std::array<Frame, kFramesMax> inbox_{};
  TxQueue tx_;
};

struct InStep {
  Runner runner;
  port::LockstepMember member;

  InStep(const std::string& interface, EcuNode node)
      : runner(std::move(node)), member(interface, runner.node().member, runner.node().listens_to) {}
};

std::string names_of(const std::deque<InStep>& nodes) {
  std::string out;
  for (const InStep& n : nodes)
    out += (out.empty() ? "" : " and ") + std::string(port::member_name(n.runner.node().member));
  return out;
}

/// What a node waits for until it is its turn; anything but a step ends the run.
Wake await_turn(InStep& node) {
  port::Silence silence;
  while (!interrupted()) {
    const Wake wake = node.member.wait();
    if (wake == Wake::kStep || wake == Wake::kStop) return wake;
    if (wake == Wake::kAlive) silence.end();
    if (wake == Wake::kNone && silence.go_on() > kSilence_s) return Wake::kNone;
  }
  return Wake::kStop;
}

/// READY of all nodes until the first of them is called.
Wake await_start(std::deque<InStep>& nodes) {
  while (!interrupted()) {
    for (InStep& n : nodes) n.member.announce();
    const Wake wake = nodes.front().member.wait();
    if (wake == Wake::kStep || wake == Wake::kStop) return wake;
  }
  return Wake::kStop;
}

/// The last wait of a node that is alone: its firmware sees that frames are missing, and says so on the bus.
int step_alone(std::deque<InStep>& nodes) {
  VOLTLAP_DEMAND(!nodes.empty());
  const std::uint32_t last = nodes.front().member.tick();
  fmt::print(
      stderr,
      "voltlap ecu: no word from the plant for {} s after tick {} ({:.2f} s): {} by the wall clock to the "
      "safe state\n",
      kSilence_s, last, last * can::kTickMs * 1e-3, names_of(nodes));
  port::Pacer pacer(kTick_us, port::Lag::kCatchUp);
  for (std::uint32_t i = 1; i <= kAlone_ticks && !interrupted(); ++i) {
    pacer.wait();
    for (InStep& n : nodes) {
      port::Can& can = n.member.data();
      static_cast<void>(can.send(n.runner.step(Instant::from_ms((last + i) * can::kTickMs), can)));
    }
  }
  return kExitFailedRun;
}

}  // namespace

int run_in_lockstep(const std::string& interface, std::vector<EcuNode> list) {
  VOLTLAP_DEMAND(!list.empty());
  std::deque<InStep> nodes;
  for (EcuNode& node : list) nodes.emplace_back(interface, std::move(node));
  Wake wake = await_start(nodes);
  while (wake == Wake::kStep) {
    for (InStep& n : nodes) {
      if (&n != &nodes.front()) wake = await_turn(n);
      if (wake != Wake::kStep) break;
      n.member.done(n.runner.step(n.member.now(), n.member.data()));
    }
    if (wake == Wake::kStep) wake = await_turn(nodes.front());
  }
  if (interrupted()) return exit_code_of_interrupt();
  return wake == Wake::kNone ? step_alone(nodes) : kExitOk;
}

int run_in_real_time(const std::string& interface, std::vector<EcuNode> list) {
  VOLTLAP_DEMAND(!list.empty());
  struct Node {
    Runner runner;
    port::SocketCan can;
    Node(const std::string& on, EcuNode node)
        : runner(std::move(node)), can(on, {.filters = runner.node().listens_to, .error_frames = true}) {}
  };
  std::deque<Node> nodes;
  for (EcuNode& node : list) nodes.emplace_back(interface, std::move(node));
  port::Pacer pacer(kTick_us, port::Lag::kCatchUp);
  std::uint32_t tick = 0;
  for (; !interrupted(); ++tick) {
    pacer.wait();
    for (Node& n : nodes) {
      static_cast<void>(
          static_cast<port::Can&>(n.can).send(n.runner.step(Instant::from_ms(tick * can::kTickMs), n.can)));
    }
  }
  for (const Node& n : nodes) {
    fmt::print(stderr, "voltlap ecu {}: {} steps, {} late, the latest by {:.1f} ms\n",
               port::member_name(n.runner.node().member), tick, pacer.late_steps(),
               static_cast<double>(pacer.worst_us()) * 1e-3);
  }
  return exit_code_of_interrupt();
}

}  // namespace voltlap::plant
