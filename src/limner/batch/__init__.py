"""Many photos go in; a folder of drawings, a manifest and a contact sheet come out, on this machine or on a cluster."""
