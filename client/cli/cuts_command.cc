// What there is to do with a sheet's cuts as a whole: list, export, apply, undo, redo; and its pieces.

#include <cstdio>
#include <memory>
#include <string>

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <nlohmann/json.hpp>

#include "client/cli/app.h"
#include "client/cli/commands.h"
#include "client/cpp/client.h"
#include "server/host/disk.h"
#include "server/wire/json.h"

namespace kerf::cli {
namespace {

constexpr std::size_t kMaxBatchFileBytes = std::size_t{16} << 20;

struct CutsArguments {
  std::string id;
  std::string export_to;
  std::string apply;
  std::int64_t cancel = 0;
};

// Of a ScheduledCuts, what --cancel takes: "3" of sheets/demo/scheduledCuts/3.
std::string number_of(const std::string& name) {
  return name.substr(name.rfind('/') + 1);
}

// All pages as one message. `list`: CutService::Stub::ListCuts or ListPieces.
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
  host::RealDisk disk;
  const Status written = disk.write_file(path, to_script_json(batch) + "\n");
  if (!written) return refuse(written.error());
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
  client::Client client(session.server);
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
  if (!arguments.apply.empty()) return cut_batch(session, arguments.id, arguments.apply, 0);
  client::Client client(session.server);
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
  client::Client client(session.server);
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
  client::Client client(session.server);
  Request request;
  request.set_parent("sheets/" + id);
  v1::UndoResult result;
  const grpc::Status status = client.call(method, client.cuts(), request, result);
  if (!status.ok()) return refuse(status, session.server);
  if (session.json) {
    std::printf("%s\n", to_script_json(result).c_str());
    return kDone;
  }
  std::printf("%s at tick %lld: %d %s, %d %s now; %d more to undo, %d to redo\n", what,
              static_cast<long long>(result.tick()), result.cuts_size(), result.cuts_size() == 1 ? "cut" : "cuts",
              result.pieces(), result.pieces() == 1 ? "piece" : "pieces", result.undo_steps(), result.redo_steps());
  return kDone;
}

}  // namespace

int cut_batch(const Session& session, const std::string& id, const std::string& file, std::int64_t at_tick) {
  host::RealDisk disk;
  const Result<std::string> json = disk.read_file(file, kMaxBatchFileBytes);
  if (!json) return refuse(json.error());
  v1::CutBatch batch;
  if (const Status parsed = wire::from_json(*json, batch); !parsed) {
    Error error = parsed.error();
    error.message = file + ": " + error.message;
    return refuse(error);
  }
  v1::CreateCutsRequest request;
  request.set_parent("sheets/" + id);
  request.set_at_tick(at_tick);
  *request.mutable_cuts() = std::move(*batch.mutable_cuts());
  client::Client client(session.server);
  v1::CreateCutsResponse response;
  const grpc::Status status = client.call(&v1::CutService::Stub::CreateCuts, client.cuts(), request, response);
  if (!status.ok()) return refuse(status, session.server);
  if (session.json) {
    std::printf("%s\n", to_script_json(response).c_str());
    return kDone;
  }
  const auto tick = static_cast<long long>(response.tick());
  if (response.status() == v1::CutResult::SCHEDULED) {
    std::printf(
        "SCHEDULED for tick %lld: %d cuts; `kerf cuts %s` tells what became of them, `--cancel %s` takes them back\n",
        tick, request.cuts_size(), id.c_str(), number_of(response.scheduled_name()).c_str());
    return kDone;
  }
  std::printf(
      "%d of %d cuts APPLIED at tick %lld: %d %s, %d new vertices, %d new triangles\n"
      "  topology version %d, state hash %s\n"
      "  queued %.0f us, cuts %.0f us, model update %.0f us\n",
      response.applied(), response.results_size(), tick, response.pieces(), response.pieces() == 1 ? "piece" : "pieces",
      response.new_vertices(), response.new_triangles(), response.topology_version(), response.state_hash().c_str(),
      response.queued_us(), response.cut_us(), response.update_us());
  return kDone;
}

void add_cuts_commands(CLI::App& app, Session& session) {
  const auto arguments = std::make_shared<CutsArguments>();
  CLI::App* cuts = app.add_subcommand(
      "cuts",
      "List a sheet's cuts, those that wait for their tick and those refused then; take back one that waits; or carry\n"
      "them to another sheet.\n"
      "Example: kerf cuts demo --export cuts.json && kerf cuts flag --apply cuts.json");
  cuts->group(group::kCuts);
  add_sheet_id(*cuts, arguments->id);
  CLI::Option* export_to =
      cuts->add_option("--export", arguments->export_to, "Write the cuts that are not undone to this file (JSON)")
          ->type_name(value::kFile);
  CLI::Option* apply = cuts->add_option("--apply", arguments->apply,
                                        "Make the cuts of this file, all or none (as kerf cut ID --batch FILE)")
                           ->type_name(value::kFile)
                           ->excludes(export_to);
  cuts->add_option("--cancel", arguments->cancel,
                   "Take back the call of this number that waits for its tick (kerf cut ID --at-tick, which tells it)")
      ->check(CLI::PositiveNumber)
      ->excludes(export_to)
      ->excludes(apply);
  cuts->callback(
      [&session, arguments] { session.action = [&session, arguments] { return list_cuts(session, *arguments); }; });

  add_sheet_command(app, session, "undo",
                    "Take the last cut (or batch of cuts) back: the mesh is what it was, the motion goes on",
                    [](const Session& s, const std::string& id) {
                      return undo_or_redo(s, id, "UNDONE", &v1::CutService::Stub::UndoCut);
                    })
      ->group(group::kCuts);
  add_sheet_command(app, session, "redo", "Make the cut that was undone last again",
                    [](const Session& s, const std::string& id) {
                      return undo_or_redo(s, id, "REDONE", &v1::CutService::Stub::RedoCut);
                    })
      ->group(group::kCuts);
  add_sheet_command(app, session, "pieces", "List the pieces of a sheet: id, parent, area, mass, centroid", list_pieces)
      ->group(group::kCuts);
}

}  // namespace kerf::cli
