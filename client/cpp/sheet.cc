#include "client/cpp/sheet.h"

#include <bit>
#include <cstring>
#include <utility>

#include "client/cpp/connection.h"
#include "client/cpp/transfers.h"

namespace kerf::client {
namespace {

constexpr std::int32_t kPageSize = 1000;

static_assert(std::endian::native == std::endian::little, "states are little-endian");

template <typename Number>
std::vector<Number> numbers(const std::string& bytes) {
  std::vector<Number> values(bytes.size() / sizeof(Number));
  std::memcpy(values.data(), bytes.data(), values.size() * sizeof(Number));
  return values;
}

}  // namespace

Sheet::Sheet(std::shared_ptr<Connection> connection, std::string id)
    : connection_(std::move(connection)), id_(std::move(id)) {}

template <typename Request>
Result<v1::Sheet> Sheet::call_by_name(grpc::Status (v1::SheetService::Stub::*method)(grpc::ClientContext*,
                                                                                     const Request&, v1::Sheet*)) {
  Request request;
  request.set_name(name());
  return connection_->call(method, connection_->client().sheets(), request);
}

template <typename Request>
Result<std::int64_t> Sheet::interact(grpc::Status (v1::InteractionService::Stub::*method)(grpc::ClientContext*,
                                                                                          const Request&,
                                                                                          v1::InteractionResponse*),
                                     Request request) {
  request.set_name(name());
  const auto reply = connection_->call(method, connection_->client().interaction(), request);
  if (!reply) return reply.failure();
  return reply->tick();
}

Result<v1::CutResult> Sheet::cut(const v1::Curve& curve, const CutOptions& options, std::int64_t at_tick,
                                 const std::string& request_id) {
  v1::CreateCutRequest request;
  request.set_parent(name());
  *request.mutable_cut() = make_cut(curve, options);
  request.set_at_tick(at_tick);
  request.set_request_id(request_id);
  return connection_->call(&v1::CutService::Stub::CreateCut, connection_->client().cuts(), request);
}

Result<v1::CreateCutsResponse> Sheet::cut_all(std::span<const v1::Cut> cuts, std::int64_t at_tick,
                                              const std::string& request_id) {
  v1::CreateCutsRequest request;
  request.set_parent(name());
  request.mutable_cuts()->Assign(cuts.begin(), cuts.end());
  request.set_at_tick(at_tick);
  request.set_request_id(request_id);
  return connection_->call(&v1::CutService::Stub::CreateCuts, connection_->client().cuts(), request);
}

Result<v1::UndoResult> Sheet::undo() {
  v1::UndoCutRequest request;
  request.set_parent(name());
  return connection_->call(&v1::CutService::Stub::UndoCut, connection_->client().cuts(), request);
}

Result<v1::UndoResult> Sheet::redo() {
  v1::RedoCutRequest request;
  request.set_parent(name());
  return connection_->call(&v1::CutService::Stub::RedoCut, connection_->client().cuts(), request);
}

Result<v1::ListCutsResponse> Sheet::cuts() {
  v1::ListCutsRequest request;
  request.set_parent(name());
  request.set_page_size(kPageSize);
  v1::ListCutsResponse all;
  do {
    const auto page = connection_->call(&v1::CutService::Stub::ListCuts, connection_->client().cuts(), request);
    if (!page) return page.failure();
    all.MergeFrom(*page);
    request.set_page_token(page->next_page_token());
  } while (!request.page_token().empty());
  all.clear_next_page_token();
  return all;
}

Result<v1::ScheduledCuts> Sheet::cancel(const std::string& scheduled_name) {
  v1::CancelScheduledCutsRequest request;
  request.set_name(scheduled_name);
  return connection_->call(&v1::CutService::Stub::CancelScheduledCuts, connection_->client().cuts(), request);
}

Result<std::vector<v1::Piece>> Sheet::pieces() {
  v1::ListPiecesRequest request;
  request.set_parent(name());
  request.set_page_size(kPageSize);
  std::vector<v1::Piece> all;
  do {
    const auto page = connection_->call(&v1::CutService::Stub::ListPieces, connection_->client().cuts(), request);
    if (!page) return page.failure();
    all.insert(all.end(), page->pieces().begin(), page->pieces().end());
    request.set_page_token(page->next_page_token());
  } while (!request.page_token().empty());
  return all;
}

Result<v1::Sheet> Sheet::get() {
  return call_by_name(&v1::SheetService::Stub::GetSheet);
}
Result<v1::Sheet> Sheet::pause() {
  return call_by_name(&v1::SheetService::Stub::PauseSheet);
}
Result<v1::Sheet> Sheet::resume() {
  return call_by_name(&v1::SheetService::Stub::ResumeSheet);
}
Result<v1::Sheet> Sheet::reset() {
  return call_by_name(&v1::SheetService::Stub::ResetSheet);
}

Result<v1::Sheet> Sheet::step(std::int32_t ticks) {
  v1::StepSheetRequest request;
  request.set_name(name());
  request.set_ticks(ticks);
  return connection_->call(&v1::SheetService::Stub::StepSheet, connection_->client().sheets(), request);
}

Result<v1::Sheet> Sheet::set_speed(double speed) {
  v1::SetSheetSpeedRequest request;
  request.set_name(name());
  request.set_speed(speed);
  return connection_->call(&v1::SheetService::Stub::SetSheetSpeed, connection_->client().sheets(), request);
}

Result<Done> Sheet::remove() {
  v1::DeleteSheetRequest request;
  request.set_name(name());
  const auto reply = connection_->call(&v1::SheetService::Stub::DeleteSheet, connection_->client().sheets(), request);
  if (!reply) return reply.failure();
  return Done{};
}

Result<v1::SavedState> Sheet::save_state(const std::string& state_id, bool overwrite, const std::string& request_id) {
  v1::SaveStateRequest request;
  request.set_parent(name());
  request.set_state_id(state_id);
  request.set_overwrite(overwrite);
  request.set_request_id(request_id);
  return connection_->call(&v1::SheetService::Stub::SaveState, connection_->client().sheets(), request);
}

Result<v1::Sheet> Sheet::restore_state(const std::string& state_id, const std::string& request_id) {
  v1::RestoreStateRequest request;
  request.set_name(name() + "/states/" + state_id);
  request.set_request_id(request_id);
  return connection_->call(&v1::SheetService::Stub::RestoreState, connection_->client().sheets(), request);
}

Result<std::vector<v1::SavedState>> Sheet::states() {
  v1::ListStatesRequest request;
  request.set_parent(name());
  const auto reply = connection_->call(&v1::SheetService::Stub::ListStates, connection_->client().sheets(), request);
  if (!reply) return reply.failure();
  return std::vector<v1::SavedState>(reply->states().begin(), reply->states().end());
}

Result<Done> Sheet::delete_state(const std::string& state_id) {
  v1::DeleteStateRequest request;
  request.set_name(name() + "/states/" + state_id);
  const auto reply = connection_->call(&v1::SheetService::Stub::DeleteState, connection_->client().sheets(), request);
  if (!reply) return reply.failure();
  return Done{};
}

Result<std::int64_t> Sheet::grab(v1::Grab grab, std::optional<Vector> target, double stiffness_npm) {
  if (target) *grab.mutable_target() = vec3(*target);
  grab.set_stiffness_npm(stiffness_npm);
  v1::GrabPointRequest request;
  *request.mutable_grab() = std::move(grab);
  return interact(&v1::InteractionService::Stub::GrabPoint, std::move(request));
}

Result<std::int64_t> Sheet::grab(const std::string& grab_id, Point material, std::optional<Vector> target,
                                 double stiffness_npm) {
  v1::Grab message;
  message.set_grab_id(grab_id);
  *message.mutable_material() = vec2(material);
  return grab(std::move(message), target, stiffness_npm);
}

Result<std::int64_t> Sheet::grab_vertex(const std::string& grab_id, std::int32_t vertex, std::optional<Vector> target,
                                        double stiffness_npm) {
  v1::Grab message;
  message.set_grab_id(grab_id);
  message.set_vertex(vertex);
  return grab(std::move(message), target, stiffness_npm);
}

Result<std::int64_t> Sheet::drag(const std::string& grab_id, Vector target) {
  v1::DragPointRequest request;
  request.mutable_drag()->set_grab_id(grab_id);
  *request.mutable_drag()->mutable_target() = vec3(target);
  return interact(&v1::InteractionService::Stub::DragPoint, std::move(request));
}

Result<std::int64_t> Sheet::release(const std::string& grab_id) {
  v1::ReleasePointRequest request;
  request.mutable_release()->set_grab_id(grab_id);
  return interact(&v1::InteractionService::Stub::ReleasePoint, std::move(request));
}

Result<std::int64_t> Sheet::set_pins(std::span<const v1::Region> pins) {
  v1::SetSheetPinsRequest request;
  request.mutable_set_pins()->mutable_pins()->Assign(pins.begin(), pins.end());
  return interact(&v1::InteractionService::Stub::SetSheetPins, std::move(request));
}

Result<std::int64_t> Sheet::set_gravity(Vector gravity_mps2) {
  v1::SetSheetGravityRequest request;
  *request.mutable_set_gravity()->mutable_gravity_mps2() = vec3(gravity_mps2);
  return interact(&v1::InteractionService::Stub::SetSheetGravity, std::move(request));
}

Result<std::int64_t> Sheet::set_wind(const std::optional<v1::Wind>& wind) {
  v1::SetSheetWindRequest request;
  request.mutable_set_wind();
  if (wind) *request.mutable_set_wind()->mutable_wind() = *wind;
  return interact(&v1::InteractionService::Stub::SetSheetWind, std::move(request));
}

Result<std::int64_t> Sheet::set_material(const v1::Material& material, std::optional<std::int32_t> part) {
  v1::SetSheetMaterialRequest request;
  *request.mutable_set_material()->mutable_material() = material;
  if (part) request.mutable_set_material()->set_part(*part);
  return interact(&v1::InteractionService::Stub::SetSheetMaterial, std::move(request));
}

Result<std::int64_t> Sheet::set_self_contact(const v1::SetSelfContact& change) {
  v1::SetSheetSelfContactRequest request;
  *request.mutable_set_self_contact() = change;
  return interact(&v1::InteractionService::Stub::SetSheetSelfContact, std::move(request));
}

Result<State> Sheet::state() {
  v1::GetSheetStateRequest request;
  request.set_name(name());
  const auto reply = connection_->call(&v1::SheetService::Stub::GetSheetState, connection_->client().sheets(), request);
  if (!reply) return reply.failure();
  return State{reply->tick(),
               reply->topology_version(),
               reply->state_hash(),
               numbers<double>(reply->positions()),
               numbers<double>(reply->velocities()),
               numbers<double>(reply->material_positions()),
               numbers<std::int32_t>(reply->triangles()),
               numbers<std::int32_t>(reply->pieces())};
}

Result<v1::RenderImageResponse> Sheet::render(const RenderOptions& options) {
  v1::RenderImageRequest request;
  request.set_name(name());
  request.set_width_px(options.width_px);
  request.set_height_px(options.height_px);
  if (options.camera) *request.mutable_camera() = *options.camera;
  request.set_wireframe(options.wireframe);
  request.set_undeformed(options.undeformed);
  request.set_color_by(options.color_by);
  request.set_format(options.format);
  request.set_jpeg_quality(options.jpeg_quality);
  request.set_dark(options.dark);
  return connection_->call(&v1::RenderService::Stub::RenderImage, connection_->client().render(), request);
}

Result<std::string> Sheet::obj() {
  return exported(v1::ExportSheetRequest::OBJ);
}
Result<std::string> Sheet::gltf() {
  return exported(v1::ExportSheetRequest::GLTF);
}

Result<std::string> Sheet::recording() {
  std::string file;
  const grpc::Status status = fetch_recording(connection_->client(), name(), file, connection_->timeout());
  if (!status.ok()) return failure_of(status);
  return file;
}

Result<std::string> Sheet::exported(v1::ExportSheetRequest::Format format) {
  v1::ExportSheetRequest request;
  request.set_name(name());
  request.set_format(format);
  auto reply = connection_->call(&v1::SheetService::Stub::ExportSheet, connection_->client().sheets(), request);
  if (!reply) return reply.failure();
  return std::move(*reply->mutable_content());
}

Result<v1::AnalyzeSheetResponse> Sheet::analyze(v1::AnalyzeSheetRequest request) {
  request.set_name(name());
  return connection_->call(&v1::SheetService::Stub::AnalyzeSheet, connection_->client().sheets(), request);
}

Result<v1::Ended> Sheet::watch(const Watcher::OnFrame& on_frame, const WatchOptions& options) {
  Watcher watcher(connection_->client());
  const grpc::Status status = watcher.run(name(), options, on_frame);
  if (!status.ok()) return failure_of(status);
  return watcher.ended();
}

Result<v1::Ended> Sheet::subscribe(const Watcher::OnFrame& on_frame, const SubscribeOptions& options) {
  v1::SubscribeRequest request;
  request.set_name(name());
  request.set_max_rate_hz(options.rate_hz);
  request.set_max_frames(options.max_frames);
  grpc::ClientContext context;
  const auto stream = connection_->client().stream().Subscribe(&context, request);
  Mirror mirror;
  v1::WatchResponse response;
  v1::Ended ended;
  while (stream->Read(&response)) {
    if (response.has_ended()) ended = response.ended();
    if (!response.has_frame()) continue;
    const std::optional<grpc::Status> wrong = misfit(mirror, response.frame());
    if (!wrong && on_frame(response.frame(), mirror)) continue;
    context.TryCancel();
    stream->Finish();
    if (wrong) return failure_of(*wrong);
    return ended;
  }
  if (const grpc::Status status = stream->Finish(); !status.ok()) return failure_of(status);
  return ended;
}

Result<v1::Ended> Sheet::watch_images(const ImageWatcher::OnImage& on_image, const ImageOptions& options) {
  ImageWatcher watcher(connection_->client());
  const grpc::Status status = watcher.run(name(), options, on_image);
  if (!status.ok()) return failure_of(status);
  return watcher.ended();
}

}  // namespace kerf::client
