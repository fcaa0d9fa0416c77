// SPDX-License-Identifier: Apache-2.0
#include "learn/bench/plan_file.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <map>

#include "core/errors.hpp"
#include "core/parameter_table.hpp"
#include "core/toml_text.hpp"
#include "learn/bench/plan_check.hpp"
#include "learn/bench/plan_rows.hpp"

namespace voltlap::plant {
namespace {

namespace fs = std::filesystem;

struct Assignment {
  std::shared_ptr<toml::node> value;
  std::string place;       ///< "file:line, key" or "--set key"
  bool inherited = false;  ///< from a base plan, which may be of another kind
};
using Assignments = std::map<std::string, Assignment>;

constexpr int kBaseDepthMax = 8;
constexpr std::string_view kKinds[] = {"pulse", "random", "hppc"};

void put(Assignments& into, const std::string& key, Assignment assignment) {
  if (find_plan_row(key) == nullptr) {
    std::vector<std::string> known;
    for (const PlanRow& row : plan_rows()) known.emplace_back(row.key);
    const std::string nearest = nearest_of(key, known, key.size() / 2);
    throw InputError(
        assignment.place, fmt::format("the key \"{}\"", key), "a key of a bench plan",
        nearest.empty() ? "See docs/bench.md for all keys" : fmt::format("The nearest one is \"{}\"", nearest));
  }
  into.insert_or_assign(key, std::move(assignment));
}

void flatten(const toml::table& table, const std::string& prefix, const std::string& file, bool inherited,
             Assignments& into) {
  for (const auto& [name, node] : table) {
    const std::string key = prefix + std::string(name.str());
    if (const toml::table* section = node.as_table()) {
      flatten(*section, key + ".", file, inherited, into);
    } else {
      put(into, key, {copy_of(node), fmt::format("{}:{}, {}", file, node.source().begin.line, key), inherited});
    }
  }
}

void check_kind(const std::string& file, const std::string& kind) {
  for (const auto known : kKinds) {
    if (kind == known) return;
  }
  throw InputError(file, kind.empty() ? "no kind" : fmt::format("kind = \"{}\"", kind),
                   "\"pulse\", \"random\" or \"hppc\"",
                   "Say what kind of test it is in the first lines of the plan");
}

void read_plan(const DataFolder& data, const std::string& path, int depth, Assignments& into, BenchPlan& plan) {
  const std::string file = shown_path(path);
  if (depth > kBaseDepthMax) {
    throw InputError(file + ", base", fmt::format("more than {} plans built on each other", kBaseDepthMax),
                     "a chain of plans that ends in one without base", "Remove one of the base lines");
  }
  toml::table table = parse_toml_file(path);
  const toml::node* base_line = table.get("base");
  const std::string place =
      base_line == nullptr ? "" : fmt::format("{}:{}, base", file, base_line->source().begin.line);
  const std::string base = take_word(table, "base", file);
  if (!base.empty()) {
    read_plan(data, data.find("bench", base, place, fs::path(path).parent_path().string()), depth + 1, into, plan);
  }
  const std::string kind = take_word(table, "kind", file);
  if (!kind.empty()) plan.kind = kind;
  check_kind(file, plan.kind);
  plan.name = fs::path(path).stem().string();
  flatten(table, "", file, depth > 0, into);
}

class Store {
 public:
  Store(BenchPlan& into, const PlanRow& row, const Assignment& from) : into_(into), row_(row), from_(from) {}

  void operator()(double& (*access)(BenchPlan&)) const { access(into_) = number(*from_.value); }
  void operator()(int& (*access)(BenchPlan&)) const {
    if (!from_.value->is_integer()) wrong(*from_.value);
    access(into_) = static_cast<int>(number(*from_.value));
  }
  void operator()(bool& (*access)(BenchPlan&)) const {
    if (!from_.value->is_boolean()) wrong(*from_.value);
    access(into_) = *from_.value->value<bool>();
  }
  void operator()(std::string& (*access)(BenchPlan&)) const {
    const auto word = from_.value->value<std::string>();
    const std::string choices = fmt::format("|{}|", row_.unit);
    if (!word || (!row_.unit.empty() && choices.find("|" + *word + "|") == std::string::npos)) wrong(*from_.value);
    access(into_) = *word;
  }
  void operator()(std::vector<double>& (*access)(BenchPlan&)) const {
    std::vector<double>& list = access(into_);
    list.clear();
    const toml::array* array = from_.value->as_array();
    if (array == nullptr) return list.push_back(number(*from_.value));
    for (const toml::node& element : *array) list.push_back(number(element));
    if (list.empty()) wrong(*from_.value);
  }

 private:
  [[nodiscard]] double number(const toml::node& node) const {
    const auto value = number_of(node);
    if (!value || !(*value >= row_.low && *value <= row_.high)) wrong(node);
    return *value;
  }
  [[noreturn]] void wrong(const toml::node& node) const {
    throw InputError(from_.place, found_text(node), plan_expectation(row_), "Correct the value");
  }

  BenchPlan& into_;
  const PlanRow& row_;
  const Assignment& from_;
};

bool has_kind(const PlanRow& row, const std::string& kind) {
  return row.kinds.find(kind) != std::string_view::npos;
}

void store(const Assignments& given, const std::string& file, BenchPlan& plan) {
  for (const PlanRow& row : plan_rows()) {
    const auto assignment = given.find(std::string(row.key));
    if (assignment == given.end()) {
      if (!row.required || !has_kind(row, plan.kind)) continue;
      throw InputError(
          file, fmt::format("no {}", row.key), plan_expectation(row),
          fmt::format("Add a line for it ({}), or start from another plan with base = \"pulse_15\"", row.meaning));
    }
    if (!has_kind(row, plan.kind)) {
      if (assignment->second.inherited) continue;
      throw InputError(assignment->second.place, fmt::format("{} in a plan of kind \"{}\"", row.key, plan.kind),
                       fmt::format("a key of that kind ({} belongs to: {})", row.key, row.kinds),
                       "Remove the line");
    }
    std::visit(Store(plan, row, assignment->second), row.access);
  }
}

}  // namespace

BenchPlan load_plan(const DataFolder& data, const std::string& name_or_path,
                    const std::vector<std::string>& settings) {
  const std::string path = data.find("bench", name_or_path, "plan");
  Assignments given;
  BenchPlan plan;
  read_plan(data, path, 0, given, plan);
  for (const std::string& text : settings) {
    Setting setting = parse_setting(text);
    put(given, setting.key, {std::move(setting.value), "--set " + setting.key, false});
  }
  store(given, shown_path(path), plan);
  std::map<std::string, std::string> origin;
  for (const auto& [key, assignment] : given) origin.emplace(key, assignment.place);
  check_plan(plan, origin, shown_path(path));
  return plan;
}

}  // namespace voltlap::plant
