#include "server/service/api/core.h"

#include <algorithm>

#include "server/core/mesh/triangle_mesh.h"
#include "server/service/api/tick_advice.h"
#include "server/service/wire/component_codec.h"
#include "server/service/wire/reply_codec.h"
#include "server/service/wire/scene_codec.h"

namespace kerf::api {
namespace {

constexpr std::size_t kMaxRequestIdBytes = 64;
constexpr std::size_t kMaxMeshNotes = 64;

v1::Sheet::RunState encode_run_state(host::RunState state) {
  switch (state) {
    case host::RunState::kRunning:
      return v1::Sheet::RUNNING;
    case host::RunState::kPaused:
      return v1::Sheet::PAUSED;
    case host::RunState::kSleeping:
      return v1::Sheet::SLEEPING;
    case host::RunState::kFailed:
      return v1::Sheet::FAILED;
  }
  return v1::Sheet::RUN_STATE_UNSPECIFIED;
}

v1::Replay encode_replay(const host::ReplayStatus& status) {
  v1::Replay replay;
  replay.set_end_tick(status.end_tick);
  replay.set_torn_bytes(status.torn_bytes);
  switch (status.state) {
    case host::ReplayState::kPlaying:
      replay.set_state(v1::Replay::PLAYING);
      break;
    case host::ReplayState::kDone:
      replay.set_state(v1::Replay::DONE);
      break;
    case host::ReplayState::kDiverged:
      replay.set_state(v1::Replay::DIVERGED);
      break;
  }
  if (status.divergence) {
    replay.set_diverged_tick(status.divergence->tick);
    replay.set_recorded_hash(wire::encode_hash(status.divergence->recorded_hash));
    replay.set_replayed_hash(wire::encode_hash(status.divergence->replayed_hash));
  }
  return replay;
}

v1::Softening encode_softening(const fem::Softening& softening) {
  v1::Softening message;
  message.set_factor(softening.factor);
  message.set_fits(softening.fits());
  message.set_counted_ms(softening.cost * 1e3);
  message.set_budget_ms(softening.budget * 1e3);
  message.set_expected_error_m(softening.expected_error);
  return message;
}

v1::LocalInertia encode_local_inertia(const fem::LocalInertiaStats& stats) {
  v1::LocalInertia message;
  message.set_clusters(stats.clusters);
  message.set_vertices(stats.vertices);
  message.set_largest_cluster_vertices(stats.largest);
  message.set_plain_substeps(stats.plain_substeps);
  message.set_planned_substeps(stats.planned_substeps);
  return message;
}

}  // namespace

Error too_many_pictures(const ApiCore& core) {
  return resource_exhausted("TOO_MANY_PICTURES",
                            std::to_string(core.options.limits.max_waiting_pictures) +
                                " pictures are already waiting, which is the limit; try again later");
}

Error too_many_files(const ApiCore& core) {
  return resource_exhausted("TOO_MANY_FILES",
                            std::to_string(core.options.limits.max_waiting_files) +
                                " exports and recordings are already waiting, which is the limit; try again later");
}

Error too_many_analyses(const ApiCore& core) {
  return resource_exhausted("TOO_MANY_ANALYSES",
                            std::to_string(core.options.limits.max_waiting_analyses) +
                                " analyses are already waiting, which is the limit; try again later");
}

void copy_sheet(const std::shared_ptr<ApiCore>& core, const std::string& sheet_id, const char* field,
                std::function<void(Result<std::shared_ptr<sheet::Sheet>>)> done) {
  using Copy = std::shared_ptr<sheet::Sheet>;  // Empty: too large to be copied.
  const std::int32_t limit = core->options.limits.max_analyzed_vertices;
  inspect<Copy>(
      core, sheet_id,
      [limit](const sheet::Sheet& sheet) {
        return sheet.mesh().num_vertices() <= limit ? std::make_shared<sheet::Sheet>(sheet) : nullptr;
      },
      field,
      [limit, field, done = std::move(done)](Result<Copy> copy) {
        if (!copy.ok() || *copy != nullptr) return done(std::move(copy));
        done(resource_exhausted("SHEET_TOO_LARGE",
                                "the sheet has more than " + std::to_string(limit) +
                                    " vertices, the limit of a copy; `kerf run` has no such limit",
                                field));
      });
}

Error server_stopping() {
  return unavailable("SERVER_STOPPING", "the server is stopping; try again later");
}

Result<std::string> addressed_sheet(const ApiCore& core, const std::string& name, const char* field) {
  if (core.stopping) return server_stopping();
  return parse_sheet_name(name, field);
}

Error with_field(Error error, const char* field) {
  if (error.field.empty() && error.code == ErrorCode::kNotFound) error.field = field;
  return error;
}

Status check_request_id(const std::string& request_id) {
  if (request_id.size() <= kMaxRequestIdBytes) return Nothing{};
  return invalid_argument("REQUEST_ID_TOO_LONG",
                          "request_id has " + std::to_string(request_id.size()) + " bytes; the limit is 64",
                          "request_id");
}

Status check_sheet_id(const std::string& id) {
  if (id.empty() || scene::is_valid_sheet_id(id)) return Nothing{};
  return invalid_argument("SHEET_ID", "sheet_id must match [a-z][a-z0-9-]{0,62}", "sheet_id");
}

v1::Sheet encode_sheet(const host::SheetStatus& status) {
  v1::Sheet sheet;
  sheet.set_name(sheet_name(status.id));
  sheet.set_created_unix_us(status.created_unix_us);
  if (status.resimulated_from_tick) sheet.set_resimulated_from_tick(*status.resimulated_from_tick);
  sheet.set_run_state(encode_run_state(status.run_state));
  sheet.set_tick(status.tick);
  sheet.set_topology_version(status.topology_version);
  sheet.set_num_vertices(status.num_vertices);
  sheet.set_num_triangles(status.num_triangles);
  sheet.set_pieces(status.pieces);
  if (status.state_hash) sheet.set_state_hash(wire::encode_hash(*status.state_hash));
  sheet.set_tick_rate_hz(status.config->tick_rate_hz);
  sheet.set_real_time_factor(status.stats.real_time_factor);
  sheet.set_speed(status.stats.speed);
  sheet.set_overruns(status.stats.overruns);
  sheet.set_slipped_s(status.stats.slipped_s);
  sheet.set_tick_cpu_us(status.stats.tick_cpu_us);
  sheet.mutable_pinned_vertices()->Assign(status.pinned_vertices.begin(), status.pinned_vertices.end());
  *sheet.mutable_scene() =
      wire::encode_settings({*status.config, status.materials, status.gravity, status.wind, status.self_contact});
  sheet.mutable_scene()->set_sheet_id(status.id);
  sheet.set_integrator(status.integrator);
  if (status.softening) *sheet.mutable_softening() = encode_softening(*status.softening);
  if (status.local_inertia) *sheet.mutable_local_inertia() = encode_local_inertia(*status.local_inertia);
  *sheet.mutable_tick_estimate() = encode_tick_estimate(status);
  sheet.set_linear_iterations(status.linear_iterations);
  sheet.set_linear_residual(status.linear_residual);
  sheet.set_intersections(status.stats.intersections);
  sheet.set_settings_version(status.stats.settings_version);
  sheet.set_strained_share(status.stats.strained_share);
  sheet.set_viewers(status.viewers);
  sheet.set_scene_tick(status.scene_tick);
  for (std::size_t i = 0; i < std::min(status.mesh_notes.size(), kMaxMeshNotes); ++i) {
    sheet.add_mesh_notes(status.mesh_notes[i]);
  }
  for (const scene::ComponentPlace& place : status.components) {
    *sheet.add_components() = wire::encode_component_place(place);
  }
  if (status.replay) *sheet.mutable_replay() = encode_replay(*status.replay);
  wire::encode_flags(status.flagged_ticks, *sheet.mutable_flagged_ticks());
  return sheet;
}

host::Callback<host::SheetStatus> sheet_reply(Reply<v1::Sheet> reply, const char* field) {
  return [reply = std::move(reply), field](Result<host::SheetStatus> status) {
    if (!status.ok()) return reply(with_field(status.error(), field));
    reply(encode_sheet(*status));
  };
}

}  // namespace kerf::api
