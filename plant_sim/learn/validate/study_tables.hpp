// SPDX-License-Identifier: Apache-2.0
// A validation as the tables of reference study, 2016, chapter 7, its numbers beside the own: what text and report
// show.
#pragma once
#include <string>
#include <vector>

#include "learn/validate/validation_study.hpp"

namespace voltlap::plant {

struct StudyTable {
  std::string title;
  std::vector<std::string> columns;            ///< the first is the rows' name
  std::vector<std::vector<std::string>> rows;  ///< as wide as the columns
  std::vector<std::string> notes;
};

/// Of what was asked for, in the order of the study.
[[nodiscard]] std::vector<StudyTable> study_tables(const CellParameters& cell, const ValidationStudy& study);

/// "r0 without current", "whole model".
[[nodiscard]] std::string reduction_name(const Reduction& reduction);
/// "12.3 mV"
[[nodiscard]] std::string millivolts(double volts);

}  // namespace voltlap::plant
