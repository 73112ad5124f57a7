#pragma once

#include <OgreColourValue.h>

#include <QString>

#include "rviz_plugins/overlay.h"

namespace tactile_clay::rviz_plugins {

/// Colour of a sound pressure.
/// @param share of the full scale, 0-1
Ogre::ColourValue soundColor(float share);

/// An upright bar with these colours, and numbers beside it.
/// @param top number at its upper end
/// @param length from there to the lower end
void paintSoundBar(Overlay& bar, const QString& title, double top, double length);

}  // namespace tactile_clay::rviz_plugins
