// SPDX-License-Identifier: Apache-2.0
#include "apps/log_convert_command.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <set>
#include <string_view>

#include "apps/exit_code.hpp"
#include "apps/flag_checks.hpp"
#include "apps/log_group.hpp"
#include "apps/progress_line.hpp"
#include "core/errors.hpp"
#include "io/atomic_file.hpp"
#include "io/logs/can/frame_writer.hpp"
#include "io/python_module.hpp"
#include "io/temporary_folder.hpp"

namespace voltlap::plant {
namespace {

constexpr std::size_t kOften = 50000;
constexpr std::size_t kPiece = std::size_t{1} << 20;

enum class Writer { kCandump, kSlcan, kPackage };
struct OutFormat {
  std::string_view suffix;
  Writer writer;
  const char* name;  ///< of the package's writer
};
constexpr std::array kFormats{OutFormat{".log", Writer::kCandump, ""},    OutFormat{".log.gz", Writer::kCandump, ""},
                              OutFormat{".slcan", Writer::kSlcan, ""},    OutFormat{".asc", Writer::kPackage, "asc"},
                              OutFormat{".blf", Writer::kPackage, "blf"}, OutFormat{".trc", Writer::kPackage, "trc"},
                              OutFormat{".mf4", Writer::kPackage, "mf4"}, OutFormat{".csv", Writer::kPackage, "csv"},
                              OutFormat{".db", Writer::kPackage, "db"}};

const OutFormat& format_of(const std::string& path) {
  if (path == AtomicFile::kStandardOutput) return kFormats.front();
  for (const OutFormat& format : kFormats) {
    if (path.ends_with(format.suffix) && path.size() > format.suffix.size()) return format;
  }
  throw InputError("OUT", path,
                   "a name that ends in .log (candump), .asc, .slcan, .blf, .trc, .mf4, .csv (GVRET) or .db (SQLite)",
                   "The end of the name says the format");
}

struct Converted {
  CanSummary summary;
  std::size_t frames = 0;
  std::set<std::string> buses;
  std::vector<std::string> notes;  ///< what the format changes
};

/// Formats that count channels from 1 give buses other numbers than their names say; some have no place for flags.
void note_losses(std::string_view words, std::vector<std::string>& notes) {
  while (words.ends_with('\n')) words.remove_suffix(1);
  const auto said = nlohmann::json::parse(words.substr(words.rfind('\n') + 1), nullptr, false);
  if (!said.is_object()) return;
  const auto facts = [&](const char* key) { return said.value(key, nlohmann::json::object()); };
  for (const auto& facts_of_channels = facts("channels"); const auto& [bus, channel] : facts_of_channels.items()) {
    const std::string number = channel.dump();
    if (bus == "can" + number) continue;
    notes.push_back(fmt::format("{} is channel {} there, and is read back as can{}", bus, number, number));
  }
  for (const char* key : {"skipped", "changed"}) {
    for (const auto& kinds = facts(key); const auto& [kind, count] : kinds.items()) {
      notes.push_back(fmt::format("the format cannot hold everything: {} {}", count.dump(), kind));
    }
  }
}

/// Text of the chosen frames, in pieces.
template <class Chosen, class Write>
Converted write_text(const RecordingInput& input, const DbcSet& dbc, Writer writer, const Chosen& chosen,
                     const Write& write) {
  const auto recording = input.open(dbc);
  ProgressLine progress("converting " + input.path());
  Converted out;
  RecordedFrame frame;
  std::string text;
  double origin_s = 0.0;
  for (std::size_t k = 1; recording->next(frame); ++k) {
    if (k == 1) origin_s = frame.time_s;
    if (k % kOften == 0) progress.show(fmt::format("{} frames", k), 0.0);
    const std::string& bus = recording->buses()[frame.bus];
    if (!chosen(frame.time_s - origin_s, bus)) continue;
    ++out.frames;
    out.buses.insert(bus);
    if (writer == Writer::kSlcan) {
      append_slcan(frame, origin_s, text);
    } else {
      append_candump(frame, bus, text);
    }
    if (text.size() < kPiece) continue;
    write(text);
    text.clear();
  }
  out.summary = recording->summary();
  if (out.frames == 0) {
    throw InputError(input.path(), "no frame that was asked for",
                     fmt::format("frames of {}, {:.3f} s in all", fmt::join(out.summary.buses, ", "),
                                 out.summary.end_s - out.summary.begin_s),
                     "Correct --bus, --from or --to; nothing was written");
  }
  write(text);
  return out;
}

}  // namespace

LogConvertCommand::LogConvertCommand(CLI::App& app)
    : command_(log_group(app).add_subcommand("convert", "The frames of a recording in another format")) {
  recording_.add(*command_);
  add_output_file(*command_, "--out", out_,
                  "The result: .log (candump, .log.gz; - for standard output), .asc, .slcan, .blf, .trc, .mf4, "
                  ".csv (GVRET), .db (SQLite)")
      ->required();
  command_->add_option("--bus", bus_, "Only the frames of this interface or channel")->check(some_name("a bus"));
  command_->add_option("--from", from_s_, "Only frames from this time after the first on [s]")
      ->check(number_from_zero());
  command_->add_option("--to", to_s_, "Only frames up to this time after the first [s]")
      ->check(number_from_zero());
  command_->footer(
      "Frames that cannot be trusted are left out and counted; error and remote frames are not carried over.\n"
      "Example: voltlap log convert drive.blf --out drive.log.gz\n"
      "Exit code: 0; 1 the file breaks off, what stands before it is written; 2 usage, input, or a result that cannot "
      "be written.");
}

int LogConvertCommand::run(const DataFolder& data) {
  const OutFormat& format = format_of(out_);
  const DbcSet dbc = recording_.dbc(data);
  recording_.refuse_as_output(out_);
  const auto chosen = [&](double time_s, const std::string& bus) {
    return time_s >= from_s_ && time_s <= to_s_ && (bus_.empty() || bus == bus_);
  };
  Converted done;
  if (format.writer != Writer::kPackage) {
    AtomicFile file(out_);
    done = write_text(recording_, dbc, format.writer, chosen, [&](const std::string& text) { file.write(text); });
    if (format.writer == Writer::kSlcan && done.buses.size() > 1) {
      throw InputError(recording_.path(), fmt::format("frames of {}", fmt::join(done.buses, ", ")),
                       "one bus: SLCAN has no place for its name", "Choose one with --bus");
    }
    file.commit();
  } else {
    const TemporaryFolder folder;
    const std::string between = folder.path() + "/frames.log";
    AtomicFile file(between);
    done = write_text(recording_, dbc, Writer::kCandump, chosen, [&](const std::string& text) { file.write(text); });
    file.commit();
    const PythonReport report =
        run_recording_module("voltlap_logs.write_frames", {"--format", format.name, out_}, {between, {}});
    note_losses(report.words, done.notes);
    constexpr double kAbsolute = 1e8;  // s; a time beyond counts from 1970
    if (std::string_view(format.name) == "asc" && done.summary.begin_s > kAbsolute) {
      done.notes.emplace_back("ASC counts from the recording's beginning; its date stands in the header, and is not "
                              "read back");
    }
  }
  std::FILE* stream = summary_stream({out_});
  for (const std::string& note : done.notes) fmt::print(stream, "  {}\n", note);
  fmt::print(stream, "{}: {} frames of {}\n{}", out_, done.frames, fmt::join(done.buses, ", "),
             remarks_text(recording_.path(), done.summary));
  return done.summary.broken.empty() ? kExitOk : kExitDefects;
}

}  // namespace voltlap::plant
