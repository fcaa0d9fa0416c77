// SPDX-License-Identifier: Apache-2.0
#include "io/play/play_list.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "core/demand.hpp"
#include "core/errors.hpp"

namespace voltlap::plant {
namespace {

constexpr std::size_t kOften = 50000;  // frames between two words on progress

/// Without a choice the frames of one bus only.
void check_buses(const std::string& path, const FrameChoice& choice, const std::vector<std::string>& buses,
                 const std::vector<bool>& chosen) {
  const bool known = std::find(buses.begin(), buses.end(), choice.channel) != buses.end();
  if (!choice.channel.empty() && !known) {
    throw InputError(path, fmt::format("no frame of {}", choice.channel),
                     fmt::format("one of {}", fmt::join(buses, ", ")), "Correct --channel");
  }
  if (std::count(chosen.begin(), chosen.end(), true) < 2) return;
  std::vector<std::string> names;
  for (std::size_t k = 0; k < chosen.size(); ++k) {
    if (chosen[k]) names.push_back(buses[k]);
  }
  throw InputError(path, fmt::format("frames of {}", fmt::join(names, ", ")), "those of one bus for one interface",
                   "Choose with --channel; the others can be played to interfaces of their own");
}

}  // namespace

void PlayList::add(const RecordedFrame& frame) {
  if (empty()) first_s_ = frame.time_s;
  Entry entry{};
  entry.at_ns = std::llround(1e9 * (frame.time_s - first_s_));
  VOLTLAP_DEMAND(empty() || entry.at_ns >= entries_.back().at_ns);
  VOLTLAP_DEMAND(frame.length <= (frame.flexible ? RecordedFrame::kMostBytes : Frame::kMaxBytes));
  entry.data = data_.size();
  entry.length = frame.length;
  entry.flags = frame.flags;
  entry.id = frame.id;
  entry.flexible = frame.flexible;
  entry.remote = frame.remote;
  if (!frame.remote) data_.insert(data_.end(), frame.data, frame.data + frame.length);
  flexible_ += frame.flexible && !frame.remote ? 1U : 0U;
  entries_.push_back(entry);
}

PlayFrame PlayList::operator[](std::size_t k) const {
  const Entry& entry = entries_[k];
  return {entry.at_ns, entry.id, entry.length, entry.flags, entry.flexible, entry.remote, data_.data() + entry.data};
}

std::int64_t PlayList::round_ns() const {
  const auto intervals = static_cast<std::int64_t>(size()) - 1;
  return intervals > 0 ? span_ns() + span_ns() / intervals : 0;
}

ReadPlayList read_play_list(CanRecording& recording, const std::string& path, const FrameChoice& choice,
                            const std::function<void(std::size_t)>& progress) {
  ReadPlayList out;
  std::vector<bool> chosen, seen(choice.ids.size(), false);
  RecordedFrame frame;
  double origin_s = 0.0;
  for (std::size_t k = 0; recording.next(frame); ++k) {
    if (k == 0) origin_s = frame.time_s;
    if (k % kOften == kOften - 1) progress(k + 1);
    const double time_s = frame.time_s - origin_s;
    if (time_s < choice.from_s || time_s > choice.to_s || !choice.has_id(frame.id)) continue;
    if (!choice.channel.empty() && recording.buses()[frame.bus] != choice.channel) continue;
    for (std::size_t n = 0; n < seen.size(); ++n) seen[n] = seen[n] || choice.ids[n].holds(frame.id);
    chosen.resize(std::max<std::size_t>(chosen.size(), frame.bus + 1U), false);
    chosen[frame.bus] = true;
    out.frames.add(frame);
  }
  const CanSummary& summary = recording.summary();
  check_buses(path, choice, summary.buses, chosen);
  if (out.frames.empty()) {
    throw InputError(path, "no frame that was asked for",
                     fmt::format("frames of {}, {:.3f} s in all", fmt::join(summary.buses, ", "),
                                 summary.end_s - summary.begin_s),
                     "Correct --from, --to, --id or --channel");
  }
  for (std::size_t n = 0; n < seen.size(); ++n) {
    if (!seen[n]) out.absent.push_back(choice.ids[n]);
  }
  return out;
}

}  // namespace voltlap::plant
