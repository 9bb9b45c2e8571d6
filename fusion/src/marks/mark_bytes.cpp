#include "marks/mark_bytes.h"

namespace rubble::fusion {

namespace {

using common::ByteReader;
using common::ByteWriter;

template <typename Matrix>
void putMatrix(ByteWriter& out, const Matrix& m) {
  out.putAll(std::span<const double>(m.data(), static_cast<std::size_t>(m.size())));
}

template <typename Matrix>
void getMatrix(ByteReader& in, Matrix& m) {
  in.getAll(std::span<double>(m.data(), static_cast<std::size_t>(m.size())));
  if (!m.allFinite()) {
    in.fail("a mark that is not finite");
  }
}

void putMark(ByteWriter& out, const Mark& mark) {
  out.put(mark.id);
  out.putText(mark.label.class_name);
  out.putText(mark.label.kind);
  out.putText(mark.label.text);
  out.put(static_cast<std::uint8_t>(mark.state));
  out.put(static_cast<std::uint8_t>(mark.by_operator));
  putMatrix(out, mark.position.p_world);
  putMatrix(out, mark.position.covariance);
  putMatrix(out, mark.R_world_object);
  out.put(mark.width);
  out.put(mark.height);
  out.put(mark.views);
  out.put(mark.evidence);
  out.put(mark.first_seen);
  out.put(mark.last_seen);
  out.put(mark.level);
  out.put(mark.keyframe_id);
  out.put(static_cast<std::uint8_t>(mark.on_level));
  out.put(static_cast<std::uint8_t>(mark.is_flat));
  putMatrix(out, mark.attitude_sum);
  out.put(static_cast<std::uint64_t>(mark.kept_views.size()));
  for (const MarkView& view : mark.kept_views) {
    putMatrix(out, view.p_world_camera);
    putMatrix(out, view.d_world);
    out.put(view.range);
    out.put(view.range_sigma);
    out.put(view.bearing_sigma);
  }
  out.put(static_cast<std::uint64_t>(mark.seen_beside.size()));
  out.putAll(std::span<const std::int32_t>(mark.seen_beside));
}

Mark getMark(ByteReader& in) {
  Mark mark;
  mark.id = in.get<std::int32_t>();
  mark.label.class_name = in.getText();
  mark.label.kind = in.getText();
  mark.label.text = in.getText();
  const auto state = in.get<std::uint8_t>();
  if (state > static_cast<std::uint8_t>(MarkState::kDiscarded)) {
    in.fail("an unknown state of a mark");
  }
  mark.state = static_cast<MarkState>(state);
  mark.by_operator = in.get<std::uint8_t>() != 0;
  getMatrix(in, mark.position.p_world);
  getMatrix(in, mark.position.covariance);
  getMatrix(in, mark.R_world_object);
  mark.width = in.get<double>();
  mark.height = in.get<double>();
  mark.views = in.get<std::int32_t>();
  mark.evidence = in.get<double>();
  mark.first_seen = in.get<common::Utime>();
  mark.last_seen = in.get<common::Utime>();
  mark.level = in.get<std::int32_t>();
  mark.keyframe_id = in.get<std::int32_t>();
  mark.on_level = in.get<std::uint8_t>() != 0;
  mark.is_flat = in.get<std::uint8_t>() != 0;
  getMatrix(in, mark.attitude_sum);
  constexpr std::size_t kViewBytes = 9 * 8;
  for (std::size_t i = in.getCount(kViewBytes); i > 0; --i) {
    MarkView& view = mark.kept_views.emplace_back();
    getMatrix(in, view.p_world_camera);
    getMatrix(in, view.d_world);
    view.range = in.get<double>();
    view.range_sigma = in.get<double>();
    view.bearing_sigma = in.get<double>();
  }
  if (mark.kept_views.empty()) {
    in.fail("a mark that was never seen");
  }
  mark.seen_beside.resize(in.getCount(sizeof(std::int32_t)));
  in.getAll(std::span<std::int32_t>(mark.seen_beside));
  return mark;
}

}  // namespace

void putMarks(ByteWriter& out, const std::vector<Mark>& marks, std::int32_t next_id) {
  out.put(next_id);
  out.put(static_cast<std::uint64_t>(marks.size()));
  for (const Mark& mark : marks) {
    putMark(out, mark);
  }
}

void getMarks(ByteReader& in, std::vector<Mark>& marks, std::int32_t& next_id) {
  next_id = in.get<std::int32_t>();
  constexpr std::size_t kLeastBytes = 300;
  for (std::size_t i = in.getCount(kLeastBytes); i > 0; --i) {
    marks.push_back(getMark(in));
  }
}

}  // namespace rubble::fusion
