// SPDX-License-Identifier: Apache-2.0
#include "io/logs/row_clock.hpp"

#include "core/demand.hpp"

namespace voltlap::plant {

RowClock row_clock(const std::vector<double>& stamps_s) {
  RowClock out;
  CanDefects defects;
  FrameClock clock(defects, 0.0);
  RecordedFrame given;
  const auto take = [&] {
    while (clock.pop(given)) {
      out.row.push_back(given.line - 1);
      out.time_s.push_back(given.time_s);
    }
  };
  for (std::size_t row = 0; row < stamps_s.size(); ++row) {
    clock.slot().time_s = stamps_s[row];
    clock.slot().line = row + 1;
    clock.push();
    take();
  }
  clock.finish();
  take();
  out.defects = defects.all();
  out.parts = clock.parts();
  VOLTLAP_DEMAND(out.row.size() == out.time_s.size() && out.row.size() <= stamps_s.size());
  return out;
}

}  // namespace voltlap::plant
