#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "client/cpp/cut_options.h"
#include "client/cpp/geometry.h"
#include "client/cpp/image_watcher.h"
#include "client/cpp/result.h"
#include "client/cpp/watcher.h"

namespace kerf::client {

class Connection;

// Holds the exact state of a sheet after a tick, in the solver's 64-bit numbers, for V vertices and S triangle slots.
struct State {
  std::int64_t tick = 0;
  std::int32_t topology_version = 0;
  std::string state_hash;                  // 16 hex digits
  std::vector<double> positions;           // 3 V: x, y, z interleaved, m, world
  std::vector<double> velocities;          // 3 V, m/s
  std::vector<double> material_positions;  // 2 V: x, y interleaved, m
  std::vector<std::int32_t> triangles;     // 3 S vertices; -1 thrice for a slot without material.
  std::vector<std::int32_t> pieces;        // S, the piece of each slot; -1 without material.
};

struct RenderOptions {
  std::int32_t width_px = 640;            // 16..4096
  std::int32_t height_px = 360;           // 16..4096
  std::optional<v1::Camera> camera = {};  // Absent: shows all of the sheet.
  bool wireframe = false;
  bool undeformed = false;  // Shows the sheet flat, with its cuts.
  v1::ColorBy color_by = v1::SIDES;
  v1::RenderImageRequest::Format format = v1::RenderImageRequest::PNG;
  std::int32_t jpeg_quality = 0;  // 1..100; 0: 85
  bool dark = false;              // Draws before a dark background.
};

struct SubscribeOptions {
  double rate_hz = 1.0;         // 0.001..10
  std::int32_t max_frames = 0;  // The stream ends after this many frames; 0: no limit.
};

// Names one sheet of a server. Each method makes a call and waits for its answer; no state of the sheet is kept here.
// Copies name the same sheet. Thread-safe.
class Sheet {
 public:
  Sheet(std::shared_ptr<Connection> connection, std::string id);

  [[nodiscard]] const std::string& id() const { return id_; }
  [[nodiscard]] std::string name() const { return "sheets/" + id_; }

  // Cuts:
  //
  // Makes one cut, wholly or not at all, at the next tick, or at once on a paused sheet. A curve that misses is no
  // error: its status is NO_INTERSECTION. at_tick > 0: the cut is made at the start of that tick, and the answer is
  // SCHEDULED. request_id: at most 64 bytes; a repeat of the same cut gets the same answer and cuts nothing more.
  Result<v1::CutResult> cut(const v1::Curve& curve, const CutOptions& options = {}, std::int64_t at_tick = 0,
                            const std::string& request_id = {});
  // Makes many cuts as one, on one tick and as one step to undo: all of them or none. 1..4096 cuts.
  Result<v1::CreateCutsResponse> cut_all(std::span<const v1::Cut> cuts, std::int64_t at_tick = 0,
                                         const std::string& request_id = {});
  Result<v1::UndoResult> undo();
  Result<v1::UndoResult> redo();
  // Lists all cuts that are not undone, oldest first, and scheduled ones that wait or were refused at their tick.
  Result<v1::ListCutsResponse> cuts();
  // Cancels a scheduled cut by the `scheduled_name` in the answer to a cut with at_tick.
  Result<v1::ScheduledCuts> cancel(const std::string& scheduled_name);
  Result<std::vector<v1::Piece>> pieces();

  // Time:
  Result<v1::Sheet> get();
  Result<v1::Sheet> pause();
  Result<v1::Sheet> resume();
  Result<v1::Sheet> step(std::int32_t ticks);  // For a paused sheet, 1..100000; returns when the ticks are done.
  // Sets the simulated seconds per second of wall time, 0.01..4; 1: live. The results of ticks are the same; only the
  // time between them changes.
  Result<v1::Sheet> set_speed(double speed);
  Result<v1::Sheet> reset();
  Result<Done> remove();

  // Saved states, by name, [a-z][a-z0-9-]{0,62}:
  //
  // Saves the state between two ticks in the server's memory. overwrite: replaces a state of this name, which is
  // refused otherwise. request_id: as in cut().
  Result<v1::SavedState> save_state(const std::string& state_id, bool overwrite = false,
                                    const std::string& request_id = {});
  // Brings a saved state back, bit for bit. Pause and speed stay as they are. undo() does not take it back.
  Result<v1::Sheet> restore_state(const std::string& state_id, const std::string& request_id = {});
  Result<std::vector<v1::SavedState>> states();  // Those saved first at first.
  Result<Done> delete_state(const std::string& state_id);

  // Interaction; each call returns the tick at which it took effect.
  //
  // Ties a material point (m) or a vertex by a spring to a target in the world (m; absent: its present place).
  // stiffness_npm 0: chosen by the server.
  Result<std::int64_t> grab(const std::string& grab_id, Point material, std::optional<Vector> target = {},
                            double stiffness_npm = 0.0);
  Result<std::int64_t> grab_vertex(const std::string& grab_id, std::int32_t vertex, std::optional<Vector> target = {},
                                   double stiffness_npm = 0.0);
  Result<std::int64_t> drag(const std::string& grab_id, Vector target);
  Result<std::int64_t> release(const std::string& grab_id);
  Result<std::int64_t> set_pins(std::span<const v1::Region> pins);  // Replaces all pins; without any the sheet is free.
  Result<std::int64_t> set_gravity(Vector gravity_mps2);
  Result<std::int64_t> set_wind(const std::optional<v1::Wind>& wind);  // Absent: no air at all.
  // Sets the material; values absent from `material` come from its own preset. part: an index into the scene's
  // materials, or -1 for the sheet outside all of these; absent: the whole sheet. reset() restores the initial
  // material.
  Result<std::int64_t> set_material(const v1::Material& material, std::optional<std::int32_t> part = {});
  // Turns contact of the sheet with itself on or off, or changes its settings. Fields that are not set stay as they
  // are; reset() restores the initial ones.
  Result<std::int64_t> set_self_contact(const v1::SetSelfContact& change);

  // Output:
  Result<State> state();
  Result<v1::RenderImageResponse> render(const RenderOptions& options = {});
  Result<std::string> obj();   // A Wavefront OBJ file.
  Result<std::string> gltf();  // A binary glTF 2.0 file, y up, with a colour for each piece.
  // Returns the bytes of a recording file of its run so far, for `kerf replay` and Server::replay().
  Result<std::string> recording();
  // Computes equilibrium, vibrations or future ticks on a copy of the sheet. The request's `name` is set by this call.
  Result<v1::AnalyzeSheetResponse> analyze(v1::AnalyzeSheetRequest request);
  // Calls on_frame with each frame, after applying it to a mirror of the sheet. Blocks until on_frame returns false or
  // the server ends the stream; Ended has the server's reason.
  Result<v1::Ended> watch(const Watcher::OnFrame& on_frame, const WatchOptions& options = {});
  // Watches at a low rate and without acknowledgements. Frames wait for a slow on_frame, which then lags behind. Use it
  // for steady logging, and watch() for all else.
  Result<v1::Ended> subscribe(const Watcher::OnFrame& on_frame, const SubscribeOptions& options = {});
  // As watch(), with pictures drawn by the server.
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
