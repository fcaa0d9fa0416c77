// SPDX-License-Identifier: Apache-2.0
// How a sample is renewed by a received value and how it grows old.
#pragma once
#include "base/sample.hpp"

namespace voltlap::codec {

/// A value that is not ok leaves the last good one and its time standing, and says so in the quality.
template <class T>
void refresh(Sample<T>& sample, bool ok, T value, Instant now) {
  if (ok) {
    sample = Sample<T>{value, now, Quality::kGood};
  } else {
    sample.quality = Quality::kInvalid;
  }
}

/// Good until its age reaches the timeout of its message. A time in the future is not good.
template <class T>
void expire(Sample<T>& sample, std::int32_t timeout_ms, Instant now) {
  const std::int32_t age_ms = (now - sample.time).ms();
  if (sample.good() && (age_ms < 0 || age_ms >= timeout_ms)) sample.quality = Quality::kStale;
}

}  // namespace voltlap::codec
