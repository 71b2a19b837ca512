// Implements the commands on all cuts of a sheet: list, export, apply, undo, redo; and on its pieces.

#include <algorithm>
#include <cstdio>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <nlohmann/json.hpp>

#include "client/cli/app.h"
#include "client/cli/commands.h"
#include "client/cli/connect.h"
#include "client/cpp/client.h"
#include "client/cpp/failure.h"
#include "server/base/disk.h"
#include "server/service/wire/json.h"

namespace kerf::cli {
namespace {

// The server's limits on one call.
constexpr int kMaxCallCuts = 4096;
constexpr std::size_t kMaxCallBytes = std::size_t{1} << 20;
// Largest batch file. A server lists up to 16 MiB of cuts, which are several times as long as text.
constexpr std::size_t kMaxBatchFileBytes = std::size_t{256} << 20;

struct CutsArguments {
  std::string id;
  std::string export_to;
  std::string apply;
  std::int64_t cancel = 0;
};

// Returns the number of a ScheduledCuts, as taken by --cancel: "3" for sheets/demo/scheduledCuts/3.
std::string number_of(const std::string& name) {
  return name.substr(name.rfind('/') + 1);
}

// Fetches all pages as one message. `list`: CutService::Stub::ListCuts or ListPieces.
template <typename Request, typename Response, typename Method, typename Merge>
grpc::Status list_all(client::Client& client, const std::string& id, Method list, Merge merge, Response& all) {
  Request request;
  request.set_parent("sheets/" + id);
  request.set_page_size(1000);
  do {
    Response page;
    const grpc::Status status = client.call(list, client.cuts(), request, page);
    if (!status.ok()) return status;
    request.set_page_token(page.next_page_token());
    merge(page, all);
  } while (!request.page_token().empty());
  return grpc::Status::OK;
}

void print_scheduled(const v1::ScheduledCuts& scheduled) {
  const auto tick = static_cast<long long>(scheduled.tick());
  const char* plural = scheduled.cuts_size() == 1 ? "cut" : "cuts";
  if (scheduled.state() == v1::ScheduledCuts::WAITING) {
    std::printf("%s waiting for tick %lld: %d %s\n", number_of(scheduled.name()).c_str(), tick, scheduled.cuts_size(),
                plural);
    return;
  }
  std::printf("REFUSED at tick %lld: %d %s: %s (%s)\n", tick, scheduled.cuts_size(), plural,
              scheduled.message().c_str(), scheduled.reason().c_str());
}

int export_cuts(const Session& session, const v1::ListCutsResponse& all, const std::string& path) {
  v1::CutBatch batch;
  for (const v1::ListCutsResponse::Entry& entry : all.cuts()) *batch.add_cuts() = entry.cut();
  RealDisk disk;
  const Status written = disk.write_file(path, to_script_json(batch) + "\n");
  if (!written.ok()) return refuse(written.error());
  if (session.json) {
    std::printf("%s\n", nlohmann::ordered_json{{"file", path}, {"cuts", batch.cuts_size()}}.dump(2).c_str());
  } else {
    std::printf("%s: %d %s\n", path.c_str(), batch.cuts_size(), batch.cuts_size() == 1 ? "cut" : "cuts");
  }
  return kDone;
}

int cancel_cuts(const Session& session, const CutsArguments& arguments) {
  v1::CancelScheduledCutsRequest request;
  request.set_name("sheets/" + arguments.id + "/scheduledCuts/" + std::to_string(arguments.cancel));
  client::Client client = connect(session.server);
  v1::ScheduledCuts cancelled;
  const grpc::Status status =
      client.call(&v1::CutService::Stub::CancelScheduledCuts, client.cuts(), request, cancelled);
  if (!status.ok()) return refuse(status, session.server);
  if (session.json) {
    std::printf("%s\n", to_script_json(cancelled).c_str());
    return kDone;
  }
  std::printf("CANCELLED: %d %s that waited for tick %lld\n", cancelled.cuts_size(),
              cancelled.cuts_size() == 1 ? "cut" : "cuts", static_cast<long long>(cancelled.tick()));
  return kDone;
}

int list_cuts(const Session& session, const CutsArguments& arguments) {
  if (arguments.cancel > 0) return cancel_cuts(session, arguments);
  if (!arguments.apply.empty()) return cut_batch(session, arguments.id, arguments.apply, {});
  client::Client client = connect(session.server);
  v1::ListCutsResponse all;
  const auto merge = [](const v1::ListCutsResponse& page, v1::ListCutsResponse& into) {
    into.mutable_cuts()->MergeFrom(page.cuts());
    into.mutable_scheduled()->MergeFrom(page.scheduled());
  };
  const grpc::Status status =
      list_all<v1::ListCutsRequest>(client, arguments.id, &v1::CutService::Stub::ListCuts, merge, all);
  if (!status.ok()) return refuse(status, session.server);
  if (!arguments.export_to.empty()) return export_cuts(session, all, arguments.export_to);
  if (session.json) {
    std::printf("%s\n", to_script_json(all).c_str());
    return kDone;
  }
  if (all.cuts().empty()) std::printf("no cuts\n");
  for (const v1::ListCutsResponse::Entry& entry : all.cuts()) {
    const v1::CutResult& result = entry.result();
    std::printf("%-24s tick %-8lld %3d pieces, %d new triangles, deviation <= %.3g m\n", result.name().c_str(),
                static_cast<long long>(result.tick()), result.pieces(), result.new_triangles(), result.deviation_m());
  }
  for (const v1::ScheduledCuts& scheduled : all.scheduled()) print_scheduled(scheduled);
  return kDone;
}

int list_pieces(const Session& session, const std::string& id) {
  client::Client client = connect(session.server);
  v1::ListPiecesResponse all;
  const auto merge = [](const v1::ListPiecesResponse& page, v1::ListPiecesResponse& into) {
    into.mutable_pieces()->MergeFrom(page.pieces());
    into.set_tick(page.tick());
    into.set_topology_version(page.topology_version());
  };
  const grpc::Status status =
      list_all<v1::ListPiecesRequest>(client, id, &v1::CutService::Stub::ListPieces, merge, all);
  if (!status.ok()) return refuse(status, session.server);
  if (session.json) {
    std::printf("%s\n", to_script_json(all).c_str());
    return kDone;
  }
  for (const v1::Piece& piece : all.pieces()) std::printf("%s\n", describe(piece).c_str());
  return kDone;
}

template <typename Request>
int undo_or_redo(const Session& session, const std::string& id, const char* what,
                 grpc::Status (v1::CutService::Stub::*method)(grpc::ClientContext*, const Request&, v1::UndoResult*)) {
  client::Client client = connect(session.server);
  Request request;
  request.set_parent("sheets/" + id);
  v1::UndoResult result;
  const grpc::Status status = client.call(method, client.cuts(), request, result);
  if (!status.ok()) return refuse(status, session.server);
  if (session.json) {
    std::printf("%s\n", to_script_json(result).c_str());
    return kDone;
  }
  const std::string step =
      result.reset() ? "the reset" : std::to_string(result.cuts_size()) + (result.cuts_size() == 1 ? " cut" : " cuts");
  std::printf("%s: %s, now %d %s; %d more to undo, %d to redo (tick %lld)\n", what, step.c_str(), result.pieces(),
              result.pieces() == 1 ? "piece" : "pieces", result.undo_steps(), result.redo_steps(),
              static_cast<long long>(result.tick()));
  return kDone;
}

// Splits the cuts, in order, into as few calls as possible, each otherwise equal to `to_sheet`. Without cuts there is
// one call too. A cut too large for any call gets its own, so that the server reports the error.
std::vector<v1::CreateCutsRequest> calls_of(v1::CutBatch& batch, const v1::CreateCutsRequest& to_sheet) {
  constexpr std::size_t kFraming = 6;  // Bytes before a cut in the message: its field number and length.
  std::vector<v1::CreateCutsRequest> calls{to_sheet};
  std::size_t bytes = to_sheet.ByteSizeLong();
  for (v1::Cut& cut : *batch.mutable_cuts()) {
    const std::size_t more = kFraming + cut.ByteSizeLong();
    const int num_cuts = calls.back().cuts_size();
    if (num_cuts == kMaxCallCuts || (num_cuts > 0 && bytes + more > kMaxCallBytes)) {
      calls.push_back(to_sheet);
      bytes = to_sheet.ByteSizeLong();
    }
    *calls.back().add_cuts() = std::move(cut);
    bytes += more;
  }
  return calls;
}

// Counts the cuts of a file made by the calls answered so far.
struct Made {
  v1::CreateCutsResponse answer;  // The answers merged, as if one call had been made.
  int num_calls = 0;
  int num_undo_steps = 0;
  int num_cuts = 0;
};

void add(const v1::CreateCutsResponse& response, int num_cuts, Made& made) {
  ++made.num_calls;
  made.num_cuts += num_cuts;
  v1::CreateCutsResponse& answer = made.answer;
  if (response.status() == v1::CutResult::APPLIED) ++made.num_undo_steps;
  if (answer.status() != v1::CutResult::APPLIED) answer.set_status(response.status());
  answer.mutable_results()->MergeFrom(response.results());
  answer.set_tick(response.tick());
  answer.set_topology_version(response.topology_version());
  answer.set_applied(answer.applied() + response.applied());
  answer.set_pieces(response.pieces());
  answer.set_new_vertices(answer.new_vertices() + response.new_vertices());
  answer.set_new_triangles(answer.new_triangles() + response.new_triangles());
  answer.set_state_hash(response.state_hash());
  answer.set_queued_us(answer.queued_us() + response.queued_us());
  answer.set_cut_us(answer.cut_us() + response.cut_us());
  answer.set_update_us(answer.update_us() + response.update_us());
  answer.set_scheduled_name(response.scheduled_name());
  if (made.num_calls == 1) answer.set_tick_before_us(response.tick_before_us());
  answer.set_tick_after_us(response.tick_after_us());
  answer.set_tick_budget_us(response.tick_budget_us());
}

// Adapts the failure of the call after those in `made`: its field must count the cuts of the file instead of the call.
client::Failure with_what_was_made(client::Failure failure, const Made& made, const std::string& file) {
  if (made.num_cuts == 0) return failure;
  int index = 0;
  int length = 0;
  if (std::sscanf(failure.field.c_str(), "cuts[%d]%n", &index, &length) == 1 && length > 0) {
    failure.field =
        "cuts[" + std::to_string(made.num_cuts + index) + "]" + failure.field.substr(static_cast<std::size_t>(length));
  }
  const char* steps = made.num_undo_steps == 1 ? " step" : " steps";
  failure.message += "; cuts[0] to cuts[" + std::to_string(made.num_cuts - 1) + "] of " + file +
                     " were made before that, and `kerf undo` takes them back in " +
                     std::to_string(made.num_undo_steps) + steps;
  return failure;
}

// Prints each warning once, up to a screenful.
void print_notes(const v1::CreateCutsResponse& answer) {
  constexpr std::size_t kMostNotes = 5;
  std::vector<std::string> notes;
  for (const v1::CutResult& result : answer.results()) {
    for (const std::string& warning : result.warnings()) {
      if (std::ranges::find(notes, warning) == notes.end()) notes.push_back(warning);
    }
  }
  for (std::size_t i = 0; i < std::min(notes.size(), kMostNotes); ++i) std::printf("  note: %s\n", notes[i].c_str());
  if (notes.size() > kMostNotes) {
    std::printf("  and %zu more notes, which --json prints\n", notes.size() - kMostNotes);
  }
}

void print_made(const Session& session, const Made& made, const std::string& id) {
  const v1::CreateCutsResponse& answer = made.answer;
  const auto tick = static_cast<long long>(answer.tick());
  if (answer.status() == v1::CutResult::SCHEDULED) {
    std::printf("SCHEDULED for tick %lld: %d cuts; `kerf cuts %s` shows the outcome, `--cancel %s` cancels them\n",
                tick, made.num_cuts, id.c_str(), number_of(answer.scheduled_name()).c_str());
    return;
  }
  std::printf("%d of %d cuts made: %d %s, %d new vertices (tick %lld)\n", answer.applied(), answer.results_size(),
              answer.pieces(), answer.pieces() == 1 ? "piece" : "pieces", answer.new_vertices(), tick);
  if (session.verbose) {
    std::printf(
        "  %d new triangles, topology version %d, state hash %s\n"
        "  queued %.0f us, cuts %.0f us, model update %.0f us; a tick takes %.3g ms, %.3g before\n",
        answer.new_triangles(), answer.topology_version(), answer.state_hash().c_str(), answer.queued_us(),
        answer.cut_us(), answer.update_us(), 1e-3 * answer.tick_after_us(), 1e-3 * answer.tick_before_us());
  }
  print_notes(answer);
  if (made.num_calls > 1) {
    std::printf("  in %d calls, each whole or not at all; `kerf undo` undoes them in %d %s\n", made.num_calls,
                made.num_undo_steps, made.num_undo_steps == 1 ? "step" : "steps");
  }
}

}  // namespace

int cut_batch(const Session& session, const std::string& id, const std::string& file, const BatchTiming& timing) {
  RealDisk disk;
  const Result<std::string> json = disk.read_file(file, kMaxBatchFileBytes);
  if (!json.ok()) return refuse(json.error());
  v1::CutBatch batch;
  if (const Status parsed = wire::from_json(*json, batch); !parsed.ok()) {
    Error error = parsed.error();
    error.message = file + ": " + error.message;
    return refuse(error);
  }
  v1::CreateCutsRequest to_sheet;
  to_sheet.set_parent("sheets/" + id);
  to_sheet.set_at_tick(timing.at_tick);
  to_sheet.set_validate_only(timing.is_dry_run);
  const std::vector<v1::CreateCutsRequest> calls = calls_of(batch, to_sheet);
  if ((timing.at_tick != 0 || timing.is_dry_run) && calls.size() > 1) {
    const std::string option = timing.is_dry_run ? "--dry-run" : "--at-tick";
    return refuse(invalid_argument("TOO_MANY",
                                   file + " takes " + std::to_string(calls.size()) +
                                       " calls of at most 4096 cuts and 1 MiB, but " + option +
                                       " works with one only: leave it out, or split the file",
                                   option));
  }
  client::Client client = connect(session.server);
  Made made;
  for (const v1::CreateCutsRequest& call : calls) {
    v1::CreateCutsResponse response;
    const grpc::Status status = client.call(&v1::CutService::Stub::CreateCuts, client.cuts(), call, response);
    if (!status.ok()) return refuse(with_what_was_made(client::failure_of(status), made, file), session.server);
    add(response, call.cuts_size(), made);
  }
  if (session.json) {
    std::printf("%s\n", to_script_json(made.answer).c_str());
  } else {
    if (timing.is_dry_run) std::printf("%s\n", kDryRun);
    print_made(session, made, id);
    if (timing.is_dry_run) print_tick_time(made.answer);
  }
  return kDone;
}

void add_cuts_commands(CLI::App& app, Session& session) {
  const auto arguments = std::make_shared<CutsArguments>();
  CLI::App* cuts = app.add_subcommand(
      "cuts",
      "List a sheet's cuts, those scheduled and those refused at their tick; cancel a scheduled one; or copy\n"
      "the cuts to another sheet.\n"
      "Example: kerf cuts demo --export cuts.json && kerf cuts flag --apply cuts.json");
  cuts->group(group::kCuts);
  add_sheet_id(*cuts, arguments->id);
  CLI::Option* export_to =
      cuts->add_option("--export", arguments->export_to, "Write the cuts that are not undone to this file (JSON)")
          ->type_name(value::kFile);
  CLI::Option* apply =
      cuts->add_option("--apply", arguments->apply, "Make the cuts of this file, as kerf cut ID --batch FILE does")
          ->type_name(value::kFile)
          ->excludes(export_to);
  cuts->add_option("--cancel", arguments->cancel,
                   "Cancel the scheduled cut with this number, which kerf cut ID --at-tick printed")
      ->check(CLI::PositiveNumber)
      ->excludes(export_to)
      ->excludes(apply);
  cuts->callback(
      [&session, arguments] { session.action = [&session, arguments] { return list_cuts(session, *arguments); }; });

  add_sheet_command(app, session, "undo", "Undo the last cut, batch of cuts or reset",
                    [](const Session& s, const std::string& id) {
                      return undo_or_redo(s, id, "Undone", &v1::CutService::Stub::UndoCut);
                    })
      ->group(group::kCuts);
  add_sheet_command(app, session, "redo", "Redo the cut or reset that was undone last",
                    [](const Session& s, const std::string& id) {
                      return undo_or_redo(s, id, "Redone", &v1::CutService::Stub::RedoCut);
                    })
      ->group(group::kCuts);
  add_sheet_command(app, session, "pieces", "List the pieces of a sheet: id, parent, area, mass, centroid", list_pieces)
      ->group(group::kCuts);
}

}  // namespace kerf::cli
