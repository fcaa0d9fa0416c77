// SPDX-License-Identifier: Apache-2.0
// Fewer points of a long recording for a chart, without losing an extreme: rows are gathered in buckets that grow with
// the time since the last step of the current, and each signal keeps its lowest and highest value of a bucket, in the
// order in which they came.
#pragma once
#include <cstddef>
#include <vector>

#include "io/page/html_series.hpp"

namespace voltlap::plant {

/// Rows first to last (exclusive).
struct RowBucket {
  std::size_t first, last;
};

/// A bucket lasts as long as a share of the time since the last row that is a step: 2 %, and more until no more than
/// `points_max` points remain, but never so long that a chart shows it as a slope. None reaches over a row of `begins`,
/// behind a gap of the recording; empty: none.
[[nodiscard]] std::vector<RowBucket> growing_buckets(const std::vector<double>& time_s, const std::vector<bool>& step,
                                                     std::size_t points_max, const std::vector<bool>& begins = {});
/// Points at which a line begins anew, the first of all left out.
[[nodiscard]] std::vector<std::size_t> bucket_begins(const std::vector<RowBucket>& buckets,
                                                     const std::vector<bool>& begins);
/// Rows at which the current has jumped by more than a twentieth of its largest value.
[[nodiscard]] std::vector<bool> current_steps(const std::vector<double>& current_a);

/// Times of the points: a bucket of one row has one point, others two, at their first and last row.
[[nodiscard]] HtmlSeries bucket_times(const std::vector<RowBucket>& buckets, const std::vector<double>& time_s);
/// A signal at those points.
[[nodiscard]] HtmlSeries bucket_extremes(const std::vector<RowBucket>& buckets, const std::string& name,
                                         double resolution, const std::vector<double>& values);

}  // namespace voltlap::plant
