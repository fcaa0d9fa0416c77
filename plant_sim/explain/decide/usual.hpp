// SPDX-License-Identifier: Apache-2.0
// What sound logs show of a cause: it is fitted in each reference as in the log, and is worth a word only where the
// log lies outside of what references give.
//
//   t = (size - mean) / sqrt(s^2 + 1/W + se^2),  mean = sum w_r size_r / W,  w_r = 1/(s0^2 + se_r^2),  W = 1/s0^2 +
//   sum w_r s^2 = (nu s0^2 + sum max(p_r d_r^2, d_r^2 - se_r^2)) / (nu + sum p_r),   d_r = size_r - mean,   p_r =
//   s0^2 w_r
//
// s0 is the size that makes a small part of a practical effect, or of what sound logs leave of the channel anyway:
// what a model misses is not the same in every log, and mean is drawn towards nothing by one reference
// that shows none. se_r is how well reference r tells the size: a drive that hardly excites a cause shows no habit
// of it. A heavy-tailed t with nu + sum p_r degrees of freedom decides.
#pragma once
#include <functional>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "explain/fit/search.hpp"

namespace voltlap::explain {

/// What references make of one number of a cause, in its own unit.
struct Habit {
  double mean = 0.0, spread = 0.0;  ///< spread: standard deviation of a further sound log
  int references = 0;
};

struct Unlike {
  bool is = false;  ///< outside of what sound logs show
  double t = 0.0, least = 0.0;
  Habit habit;
};

/// A sound log's family of these suspects alone: of forty causes few are ever asked for.
using Sound = std::function<const Family&(const std::vector<Suspect>& asked)>;

/// Bounds a family's slow noise by what sound logs show of it: an error that they do not have is none of the noise.
void bound_noise(Family& family, const std::vector<Sound>& references);

/// What sound logs leave of a channel where only their starts are fitted, in practical sizes.
struct SoundError {
  double most = 0.0, usual = 0.0;  ///< of the worst; RMS of all
  double logs = 0.0;
};
[[nodiscard]] std::map<std::string, SoundError> errors_of_sound(const std::vector<Sound>& references);

/// What an answer is held against.
struct Asked {
  std::vector<Sound> references;
  double alike = 1.0;  ///< families of this kind that are looked at
  std::map<std::string, SoundError> errors;
  explicit Asked(std::vector<Sound> sound, double families = 1.0)
      : references(std::move(sound)), alike(families), errors(errors_of_sound(references)) {}
  [[nodiscard]] SoundError error(const std::string& channel) const {
    const auto found = errors.find(channel);
    return found != errors.end() ? found->second : SoundError{};
  }
};

/// Is this member of a set unlike what the references show of it?
[[nodiscard]] Unlike unlike_of(const Family& family, const Set& set, std::size_t member, const Asked& asked);

/// Two-sided critical value of Student's t.
[[nodiscard]] double critical_t(double probability, double freedom);

}  // namespace voltlap::explain
