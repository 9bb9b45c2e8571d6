#pragma once

#include "scene/canvas.h"

// One painter per material; each fills the whole canvas.
namespace rubble::arena_sim {

void paintOsb(Canvas& canvas);
void paintPlywood(Canvas& canvas);
void paintPlanks(Canvas& canvas);
void paintConcrete(Canvas& canvas);
void paintBricks(Canvas& canvas);
void paintBoardPaint(Canvas& canvas);
void paintCardboard(Canvas& canvas);
void paintMetal(Canvas& canvas);
void paintRubber(Canvas& canvas);
void paintCloth(Canvas& canvas);
void paintSkin(Canvas& canvas);
void paintCarpet(Canvas& canvas);

/// Age: large light and dark areas, dirt towards the lower edge.
void weather(Canvas& canvas, float strength);
/// Screws around the edge and along the posts behind a board.
void addScrews(Canvas& canvas);
/// Pencil lines and figures, sprayed arrows and numbers, scratches: some on some boards.
void addHandMarks(Canvas& canvas);
/// Spots and runs, `per_area` of them on a square metre.
void addStains(Canvas& canvas, float per_area, const cv::Vec3f& colour);

}  // namespace rubble::arena_sim
