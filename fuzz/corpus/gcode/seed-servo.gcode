(limner: page 105 x 148 mm, margin 5, pen 0.5)
(pen up S300, down S700)
G21 G90 G17 G94
M3 S300
G4 P0.2
(pen black: #000000, 0.5 mm)
(stroke 1: eye)
G0 X20 Y20
M3 S700
G4 P0.2
G1 X40 Y30 F2400
G1 X50 Y20
M3 S300
G4 P0.2
(stroke 2: mouth)
G0 X60 Y60
M3 S700
G4 P0.2
M3 S300
G4 P0.2
(pen red: #c81e14, 0.3 mm)
M0
(stroke 3: face)
G0 X10 Y90
M3 S700
G4 P0.2
G1 X90 Y95 F2400
M3 S300
G4 P0.2
G0 X0 Y0
M2
