// SPDX-License-Identifier: Apache-2.0
// The outside of a cell: a cylinder or a box, by its common name or as a calliper measures it.
#pragma once
#include <string>
#include <vector>

namespace voltlap::plant {

struct CellForm {
  std::string name;              ///< "18650"; empty for a size that has none
  std::vector<double> sides_mm;  ///< diameter and length of a cylinder, or the three edges of a box

  [[nodiscard]] bool is_cylinder() const { return sides_mm.size() == 2; }
  [[nodiscard]] double volume_m3() const;
  /// With both ends, with all six faces.
  [[nodiscard]] double surface_m2() const;
  /// "18650, a cylinder of 18.35 mm x 65 mm", "a box of 127.5 mm x 42 mm x 10.7 mm".
  [[nodiscard]] std::string text() const;
};

/// The cylinders that have a name, smallest first. Outside with the sleeve; 18650 and 21700 as in data/cells, 26650
/// as the maker's sheets of the A123 ANR26650M1 and its like.
[[nodiscard]] const std::vector<CellForm>& named_cylinders();

/// "18650", "18.4x65", "127.5x42x10.7", also with "mm" behind it. Throws InputError about --size.
[[nodiscard]] CellForm cell_form(const std::string& text);

}  // namespace voltlap::plant
