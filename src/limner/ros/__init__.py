"""ROS 1: photos and services go in; portraits, motions and a drawing arm come out. Only ``middleware`` names rospy."""
