// SPDX-License-Identifier: Apache-2.0
// One node in two versions of the firmware, stepped side by side.
#pragma once
#include <cstdint>
#include <span>

#include "node_api.hpp"

namespace same_firmware {

struct Versions {
  const NodeApi* old_one = nullptr;
  const NodeApi* present = nullptr;
};
/// Ends the program when a shared object cannot be loaded.
[[nodiscard]] Versions load_versions(const char* old_file, const char* present_file);

/// What a node made of a tick. One whose requirement failed is silent until it is started anew, as on the board.
struct Outcome {
  const char* failure = nullptr;  ///< the condition that was not met
  std::size_t count = 0;
  WireFrame sent[kSentMax];

  [[nodiscard]] std::span<const WireFrame> frames() const { return {sent, count}; }
};
/// The same frames, byte by byte, in the same order; two that failed are equal, however they say it.
[[nodiscard]] bool equal(const Outcome& a, const Outcome& b);

class Pair {
 public:
  Pair(const Versions& versions, Which which, const Settings& settings);
  ~Pair();
  Pair(const Pair&) = delete;
  Pair& operator=(const Pair&) = delete;

  /// Power off and on.
  void restart();
  /// True when both versions answer alike.
  [[nodiscard]] bool tick(std::uint32_t now_ms, std::span<const WireFrame> rx);
  [[nodiscard]] const Outcome& of_old() const { return old_.outcome; }
  [[nodiscard]] const Outcome& of_present() const { return present_.outcome; }

 private:
  struct Node {
    const NodeApi* api;
    void* node = nullptr;
    Outcome outcome{};
  };
  void start(Node& node);
  void stop(Node& node);
  void step(Node& node, std::uint32_t now_ms, std::span<const WireFrame> rx) const;

  Which which_;
  Settings settings_;
  Node old_, present_;
};

}  // namespace same_firmware
