#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "client/cpp/connection.h"
#include "client/cpp/cut_options.h"
#include "client/cpp/geometry.h"
#include "client/cpp/image_watcher.h"
#include "client/cpp/result.h"
#include "client/cpp/watcher.h"

namespace kerf::client {

// The exact state of a sheet after a tick, 64-bit as it is in the solver, of V vertices and S triangle slots.
struct State {
  std::int64_t tick = 0;
  std::int32_t topology_version = 0;
  std::string state_hash;                  // 16 hex digits
  std::vector<double> positions;           // 3 V: x, y, z interleaved, m, world
  std::vector<double> velocities;          // 3 V, m/s
  std::vector<double> material_positions;  // 2 V: x, y interleaved, m
  std::vector<std::int32_t> triangles;     // 3 S vertices; -1 thrice for a slot without material
  std::vector<std::int32_t> pieces;        // S, the piece of each slot; -1 without material
};

struct RenderOptions {
  std::int32_t width_px = 640;            // 16..4096
  std::int32_t height_px = 360;           // 16..4096
  std::optional<v1::Camera> camera = {};  // absent: all of the sheet
  bool wireframe = false;
  bool undeformed = false;  // as it is cut, but flat
  v1::ColorBy color_by = v1::SIDES;
  v1::RenderImageRequest::Format format = v1::RenderImageRequest::PNG;
  std::int32_t jpeg_quality = 0;  // 1..100; 0: 85
  bool dark = false;              // before a dark backdrop
};

struct SubscribeOptions {
  double rate_hz = 1.0;         // 0.001..10
  std::int32_t max_frames = 0;  // the stream ends after so many; 0: goes on
};

// One sheet of a server, by its name. Each method is a call, which waits for its answer; nothing of the sheet is kept
// here. Copies name the same sheet. Thread-safe.
class Sheet {
 public:
  Sheet(std::shared_ptr<Connection> connection, std::string id);

  [[nodiscard]] const std::string& id() const { return id_; }
  [[nodiscard]] std::string name() const { return "sheets/" + id_; }

  // Cuts. Whole or not at all, at the next tick, at once on a paused sheet; a curve that misses is no refusal: its
  // status is NO_INTERSECTION. at_tick > 0: at the start of that tick, and the answer is SCHEDULED. request_id: at most
  // 64 bytes; a repeat of the same cut gets the same answer and cuts nothing more.
  Result<v1::CutResult> cut(const v1::Curve& curve, const CutOptions& options = {}, std::int64_t at_tick = 0,
                            const std::string& request_id = {});
  // Many as one, on one tick and one step to undo: all of them or none. 1..4096 cuts.
  Result<v1::CreateCutsResponse> cut_all(std::span<const v1::Cut> cuts, std::int64_t at_tick = 0,
                                         const std::string& request_id = {});
  Result<v1::UndoResult> undo();
  Result<v1::UndoResult> redo();
  // All pages: the cuts that are not undone, oldest first, and those that wait for their tick or were refused then.
  Result<v1::ListCutsResponse> cuts();
  // By the `scheduled_name` of the answer to a cut with at_tick.
  Result<v1::ScheduledCuts> cancel(const std::string& scheduled_name);
  Result<std::vector<v1::Piece>> pieces();

  // Time.
  Result<v1::Sheet> get();
  Result<v1::Sheet> pause();
  Result<v1::Sheet> resume();
  Result<v1::Sheet> step(std::int32_t ticks);  // of a paused sheet, 1..100000; answers when they are done
  // Simulated seconds in one of the wall's, 0.01..4; 1: live. The same ticks, farther apart.
  Result<v1::Sheet> set_speed(double speed);
  Result<v1::Sheet> reset();
  Result<Done> remove();

  // Hands. Each gives the tick at which it took effect.
  // Ties a material point (m) or a vertex to a target in the world (m; absent: where it is now). stiffness_npm 0:
  // chosen.
  Result<std::int64_t> grab(const std::string& grab_id, Point material, std::optional<Vector> target = {},
                            double stiffness_npm = 0.0);
  Result<std::int64_t> grab_vertex(const std::string& grab_id, std::int32_t vertex, std::optional<Vector> target = {},
                                   double stiffness_npm = 0.0);
  Result<std::int64_t> drag(const std::string& grab_id, Vector target);
  Result<std::int64_t> release(const std::string& grab_id);
  Result<std::int64_t> set_pins(std::span<const v1::Region> pins);  // in place of all; none: the sheet is free
  Result<std::int64_t> set_gravity(Vector gravity_mps2);
  Result<std::int64_t> set_wind(const std::optional<v1::Wind>& wind);  // absent: no air at all
  // What `material` does not give comes from its own preset. part: an index into the scene's materials, or -1: what
  // those leave; absent: all of the sheet. reset() brings the first material back.
  Result<std::int64_t> set_material(const v1::Material& material, std::optional<std::int32_t> part = {});

  // Looks.
  Result<State> state();
  Result<v1::RenderImageResponse> render(const RenderOptions& options = {});
  Result<std::string> obj();   // a Wavefront OBJ file
  Result<std::string> gltf();  // a binary glTF 2.0 file, y up, with a colour for each piece
  // What it has done since it was made, for `kerf replay` and Server::replay(): a file's bytes.
  Result<std::string> recording();
  // Equilibrium, vibrations or ticks to come, on a copy; the request's name is set here.
  Result<v1::AnalyzeSheetResponse> analyze(v1::AnalyzeSheetRequest request);
  // Blocks: calls on_frame with each frame applied to a mirror of the sheet, until it says false or the server ends the
  // stream, which Ended then tells.
  Result<v1::Ended> watch(const Watcher::OnFrame& on_frame, const WatchOptions& options = {});
  // The same at a low rate and without acknowledgements: what on_frame does not take in time waits, so that a slow one
  // lags. For steady logging; watch() is for all else.
  Result<v1::Ended> subscribe(const Watcher::OnFrame& on_frame, const SubscribeOptions& options = {});
  // As watch(), with pictures that the server draws.
  Result<v1::Ended> watch_images(const ImageWatcher::OnImage& on_image, const ImageOptions& options = {});

 private:
  template <typename Request>
  Result<v1::Sheet> call_by_name(grpc::Status (v1::SheetService::Stub::*method)(grpc::ClientContext*, const Request&,
                                                                                v1::Sheet*));
  template <typename Request>
  Result<std::int64_t> interact(grpc::Status (v1::InteractionService::Stub::*method)(grpc::ClientContext*,
                                                                                     const Request&,
                                                                                     v1::InteractionResponse*),
                                Request request);
  Result<std::int64_t> grab(v1::Grab grab, std::optional<Vector> target, double stiffness_npm);
  Result<std::string> exported(v1::ExportSheetRequest::Format format);

  std::shared_ptr<Connection> connection_;
  std::string id_;
};

}  // namespace kerf::client
