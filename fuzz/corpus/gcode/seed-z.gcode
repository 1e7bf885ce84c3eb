(limner: page 105 x 148 mm, margin 5, pen 0.5)
(pen up Z5, down Z0)
G21 G90 G17 G94
G0 Z5
(pen black: #000000, 0.5 mm)
(stroke 1: eye)
G0 X20 Y20
G1 Z0 F600
G1 X40 Y30 F2400
G1 X50 Y20
G0 Z5
(stroke 2: mouth)
G0 X60 Y60
G1 Z0 F600
G0 Z5
(pen red: #c81e14, 0.3 mm)
M0
(stroke 3: face)
G0 X10 Y90
G1 Z0 F600
G1 X90 Y95 F2400
G0 Z5
G0 X0 Y0
M2
