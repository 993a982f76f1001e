// The blend modes that a program can be built for (BLEND).

#define COMPOSITE 0
#define MAXIMUM 1
#define MINIMUM 2
#define AVERAGE 3
#define ISO 4
#ifndef BLEND
#error "BLEND: COMPOSITE, MAXIMUM, MINIMUM, AVERAGE or ISO"
#endif
// Values are accumulated, and become colours at the end. Otherwise colours are accumulated or, with DEPTHS, their positions.
#define GATHERS_VALUES (BLEND == MAXIMUM || BLEND == MINIMUM || BLEND == AVERAGE)
