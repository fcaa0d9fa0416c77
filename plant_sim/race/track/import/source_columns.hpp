// SPDX-License-Identifier: Apache-2.0
// Which column of a table is what, by the names that people give them.
#pragma once
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "race/track/import/course_source.hpp"
#include "race/track/import/source_table.hpp"

namespace voltlap::plant {

enum class Quantity {
  kX, kY, kLatitude, kLongitude, kLeftX, kLeftY, kRightX, kRightY,
  kDistance, kCurvature, kType, kSectionLength, kStraight, kRadius, kAngle,
};

class SourceColumns {
 public:
  explicit SourceColumns(const SourceTable& table);

  [[nodiscard]] bool has(Quantity quantity) const { return find(quantity).has_value(); }
  /// Throws InputError that lists the columns there are.
  [[nodiscard]] std::size_t at(Quantity quantity) const;
  /// What the file is, by its columns. Throws InputError when that is not known.
  [[nodiscard]] SourceKind kind() const;
  /// Metres in a unit of the column: by its name, its line of units or what was given; throws InputError when all three
  /// are silent or two disagree.
  [[nodiscard]] double metres_per_unit(Quantity quantity, std::optional<double> given) const;
  /// Radians in a unit of the angle column.
  [[nodiscard]] double radians_per_unit() const;

 private:
  struct Column {
    std::string name, unit;  ///< lower case, without the unit; "" without one
  };
  [[nodiscard]] std::optional<std::size_t> find(Quantity quantity) const;
  [[nodiscard]] std::string all_names() const;

  const SourceTable& table_;
  std::vector<Column> columns_;
};

}  // namespace voltlap::plant
