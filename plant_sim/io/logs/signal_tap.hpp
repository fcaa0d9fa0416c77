// SPDX-License-Identifier: Apache-2.0
// One signal of a CAN recording on its way to a role's channel. Its raw values are kept until the recording ends: some
// are no measurement, and which they are can show only in all of them.
#pragma once
#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "io/logs/channel_builder.hpp"
#include "io/logs/dbc_file.hpp"

namespace voltlap::plant {

/// The raw values of one channel.
class SignalSamples {
 public:
  void add(double time_s, std::uint64_t raw);
  /// A sample that is no measurement; `reason` is a literal.
  void mask(double time_s, const char* reason);
  void add_lost_frames(double from_s, double to_s, std::size_t frames);

  /// Values that are measurements as far as their frames tell.
  [[nodiscard]] std::vector<std::uint64_t> raw_values(const DbcSignal& signal) const;
  /// Everything in its order, read as `kind`; raw values of `no_values` are masked for the reason that stands there.
  void give(ChannelBuilder& builder, const DbcSignal& signal, DbcSignal::Kind kind,
            const std::map<std::uint64_t, const char*>& no_values) const;

 private:
  struct Lost {
    std::size_t before;  ///< sample
    double from_s, to_s;
    std::size_t frames;
  };
  std::vector<double> time_s_;
  std::vector<std::uint64_t> raw_;
  std::vector<std::pair<std::size_t, const char*>> masked_;  ///< sample and reason
  std::vector<Lost> lost_;
};

/// One signal, or one signal and its index, for the channels it feeds.
class SignalTap {
 public:
  SignalTap(DriveLog& log, const std::string& role, const RoleSource& source, const DbcMessage& message,
            const DbcSignal& signal, const DbcSignal* index);

  void take(double time_s, const RecordedFrame& frame);
  void mask(double time_s, const RecordedFrame& frame, const char* reason);
  void add_lost_frames(double from_s, double to_s, std::size_t frames);
  /// Names of the channels that it has fed.
  [[nodiscard]] std::vector<std::string> channels() const;
  /// Throws InputError for a signal of which the values leave open whether it is signed.
  void finish();

 private:
  [[nodiscard]] SignalSamples* samples_for(const RecordedFrame& frame);
  [[nodiscard]] std::string channel_of(long n) const;
  void finish(long n, const SignalSamples& samples);
  [[nodiscard]] DbcSignal::Kind kind_in(const std::vector<std::uint64_t>& raw, const std::string& channel);
  [[nodiscard]] std::map<std::uint64_t, const char*> no_values(const std::vector<std::uint64_t>& raw,
                                                               DbcSignal::Kind kind) const;

  DriveLog& log_;
  std::string role_;
  const RoleSource& source_;
  const DbcMessage& message_;
  const DbcSignal& signal_;
  const DbcSignal* index_;
  std::map<long, SignalSamples> samples_;
};

}  // namespace voltlap::plant
