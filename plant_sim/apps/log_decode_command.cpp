// SPDX-License-Identifier: Apache-2.0
#include "apps/log_decode_command.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <array>
#include <string_view>

#include "apps/exit_code.hpp"
#include "apps/flag_checks.hpp"
#include "apps/log_group.hpp"
#include "apps/progress_line.hpp"
#include "core/errors.hpp"
#include "io/atomic_file.hpp"
#include "io/logs/can/signal_columns.hpp"
#include "io/logs/can/signal_csv.hpp"
#include "io/python_module.hpp"
#include "io/temporary_folder.hpp"

namespace voltlap::plant {
namespace {

constexpr std::size_t kOften = 50000;           // frames between two words about progress
constexpr std::size_t kPiece = std::size_t{1} << 20;  // bytes of text that are written at once

/// What reads a recording once: its frames as rows of chosen signals.
template <class Take>
CanSummary for_each_row(const RecordingInput& input, const DbcSet& dbc, SignalRows& rows, const char* doing,
                        const Take& take) {
  const auto recording = input.open(dbc);
  ProgressLine progress(doing + (" " + input.path()));
  RecordedFrame frame;
  for (std::size_t k = 1; recording->next(frame); ++k) {
    if (const auto row = rows.take(frame, recording->buses())) take(*row);
    if (k % kOften == 0) progress.show(fmt::format("{} frames", k), 0.0);
  }
  return recording->summary();
}

struct Decoded {
  CanSummary summary;
  std::size_t rows = 0, signals = 0, unknown_frames = 0, refused_frames = 0;
};

void count(const SignalRows& rows, Decoded& out) {
  for (const SignalGroup& group : rows.groups()) out.signals += group.signals.size();
  out.unknown_frames = rows.unknown_frames();
  out.refused_frames = rows.refused_frames();
}

/// Read twice: the header needs every signal that will come.
Decoded decode_csv(const RecordingInput& input, const DbcSet& dbc, const SignalChoice& choice, double every_s,
                   const std::string& out_path) {
  SignalRows heard(dbc, choice);
  for_each_row(input, dbc, heard, "looking through", [](const SignalRows::Row&) {});
  Decoded out;
  count(heard, out);
  SignalRows rows(dbc, choice);
  SignalCsv csv(heard.groups(), every_s);
  AtomicFile file(out_path);
  std::string text = csv.header();
  out.summary = for_each_row(input, dbc, rows, "decoding", [&](const SignalRows::Row& row) {
    ++out.rows;
    csv.add(row, text);
    if (text.size() < kPiece) return;
    file.write(text);
    text.clear();
  });
  csv.finish(text);
  file.write(text);
  file.commit();
  return out;
}

/// By way of raw columns, which the formats' own packages write as whole arrays.
Decoded decode_columns(const RecordingInput& input, const DbcSet& dbc, const SignalChoice& choice, const char* format,
                       const std::string& out_path) {
  const TemporaryFolder folder;
  SignalColumns columns(folder.path());
  SignalRows rows(dbc, choice);
  Decoded out;
  out.summary = for_each_row(input, dbc, rows, "decoding", [&](const SignalRows::Row& row) {
    ++out.rows;
    columns.add(row);
  });
  count(rows, out);
  columns.finish(rows.groups(), input.path());
  ProgressLine progress(fmt::format("writing {}", out_path));
  progress.show("", 0.0);
  run_recording_module("voltlap_logs.write_signals", {"--format", format, folder.path(), out_path}, {});
  return out;
}

struct OutFormat {
  std::string_view suffix;
  const char* name;  ///< of the writer; nullptr: CSV, native
};
constexpr std::array kFormats{OutFormat{".csv", nullptr}, OutFormat{".csv.gz", nullptr},
                              OutFormat{".parquet", "parquet"}, OutFormat{".mf4", "mf4"}, OutFormat{".mcap", "mcap"}};

const OutFormat& format_of(const std::string& path) {
  for (const OutFormat& format : kFormats) {
    if (path.ends_with(format.suffix) && path.size() > format.suffix.size()) return format;
  }
  throw InputError("--out", path, "a name that ends in .csv, .csv.gz, .parquet, .mf4 or .mcap",
                   "The end of the name says the format");
}

}  // namespace

LogDecodeCommand::LogDecodeCommand(CLI::App& app)
    : command_(log_group(app).add_subcommand("decode", "Signals of a recording as CSV, Parquet, MF4 or MCAP")) {
  recording_.add(*command_);
  add_output_file(*command_, "--out", out_, "The result: .csv, .csv.gz, .parquet, .mf4 or .mcap")->required();
  command_
      ->add_option("--signals", signals_,
                   "Names or patterns (Pack*, BmsStatus.*), separated by commas; default: every signal")
      ->delimiter(',')
      ->allow_extra_args(false);
  command_->add_option("--every", every_s_, "CSV only: a row each so many seconds, with every signal's latest value")
      ->check(positive_number());
  command_->footer(
      "CSV has a row for each frame with its own signals filled in; --every makes a table without holes.\n"
      "Parquet: a row for each frame; MF4: a group for each frame; MCAP: a topic for each frame (PlotJuggler, "
      "Foxglove).\n"
      "Example: voltlap log decode drive.log.gz --dbc car.dbc --signals 'Pack*,Accelerator*' --out drive.csv\n"
      "Exit code: 0; 1 the file breaks off, what stands before it is written; 2 usage, input, or a result that cannot "
      "be written.");
}

int LogDecodeCommand::run(const DataFolder& data) {
  const OutFormat& format = format_of(out_);
  if (format.name != nullptr && every_s_ > 0.0) {
    throw InputError("--every", "it beside " + out_, "a CSV", "Leave it out, or name a .csv");
  }
  const DbcSet dbc = recording_.needed_dbc(data);
  recording_.refuse_as_output(out_);
  const SignalChoice choice(signals_);
  std::vector<const DbcMessage*> known;
  for (const auto& file : dbc.files()) {
    for (const DbcMessage& message : file->messages()) known.push_back(&message);
  }
  if (const auto wrong = choice.without_match(known); !wrong.empty()) {
    throw InputError("--signals", fmt::format("{}, which fits no signal", fmt::join(wrong, ", ")),
                     "names or patterns of signals in the DBC files", "voltlap log info --dbc lists them");
  }
  const Decoded decoded = format.name == nullptr ? decode_csv(recording_, dbc, choice, every_s_, out_)
                                                 : decode_columns(recording_, dbc, choice, format.name, out_);
  std::FILE* stream = summary_stream({out_});
  fmt::print(stream, "{}: {} signals of {} frames", out_, decoded.signals, decoded.rows);
  if (decoded.unknown_frames > 0) fmt::print(stream, "; {} frames that no DBC file knows", decoded.unknown_frames);
  if (decoded.refused_frames > 0) {
    fmt::print(stream, "; {} frames that a DBC file has and that cannot be used (voltlap log check says why)",
               decoded.refused_frames);
  }
  fmt::print(stream, "\n{}", remarks_text(recording_.path(), decoded.summary));
  return decoded.summary.broken.empty() ? kExitOk : kExitDefects;
}

}  // namespace voltlap::plant
